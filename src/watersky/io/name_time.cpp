// SPDX-License-Identifier: MIT
#include "watersky/io/name_time.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "watersky/io/exif.hpp"

namespace watersky {

namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

constexpr std::string_view kFields = "YMDhms";
constexpr std::array<std::size_t, 6> kDigits = {4, 2, 2, 2, 2, 2};

/// The six fields as EXIF writes them.
std::optional<Time> assembled(const std::array<std::string, 6>& f, std::string_view fraction) {
  return parse_exif_time(f[0] + ":" + f[1] + ":" + f[2] + " " + f[3] + ":" + f[4] + ":" + f[5],
                         fraction);
}

/// A date and time that begins at `stem[at]`, parts possibly separated, and ends in Z.
std::optional<Time> zulu_at(std::string_view stem, std::size_t at) {
  std::array<std::string, 6> fields;
  const auto skip = [&](std::string_view any) {
    if (at < stem.size() && any.find(stem[at]) != std::string_view::npos) ++at;
  };
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (i == 3)
      skip("T_- ");
    else if (i > 0)
      skip("-_:");
    for (std::size_t k = 0; k < kDigits[i]; ++k, ++at) {
      if (at >= stem.size() || !is_digit(stem[at])) return std::nullopt;
      fields[i] += stem[at];
    }
  }
  skip(".,_");
  std::string fraction;
  while (at < stem.size() && is_digit(stem[at]) && fraction.size() < 9) fraction += stem[at++];
  if (at >= stem.size() || stem[at] != 'Z') return std::nullopt;
  return assembled(fields, fraction);
}

}  // namespace

std::optional<Time> parse_iso8601(std::string_view text) {
  constexpr std::string_view kForm = "YYYY-MM-DDThh:mm:ss";
  if (text.size() <= kForm.size()) return std::nullopt;
  std::string date(text.substr(0, kForm.size()));
  if (date[10] == ' ') date[10] = 'T';
  std::string_view rest = text.substr(kForm.size());
  std::string fraction;
  if (rest.front() == '.' || rest.front() == ',') {
    rest.remove_prefix(1);
    while (!rest.empty() && is_digit(rest.front())) {
      fraction += rest.front();
      rest.remove_prefix(1);
    }
    if (fraction.empty()) return std::nullopt;
    fraction.resize(std::min<std::size_t>(fraction.size(), 9));
  }
  const auto offset = parse_utc_offset(rest);
  std::string pattern(kForm);
  const auto time = time_from_name(date + fraction, pattern.append(fraction.size(), 'c'));
  return time && offset ? std::optional(*time - *offset) : std::nullopt;
}

Status check_name_pattern(std::string_view pattern) {
  for (std::size_t i = 0; i < kFields.size(); ++i)
    if (static_cast<std::size_t>(std::count(pattern.begin(), pattern.end(), kFields[i])) !=
        kDigits[i])
      return Error{ErrorCode::Usage,
                   "the name pattern \"" + std::string(pattern.substr(0, 60)) +
                       "\" must hold YYYY, MM, DD, hh, mm and ss, e.g. YYYYMMDDhhmmsscc"};
  return {};
}

std::optional<Time> time_from_name(std::string_view stem, std::string_view pattern) {
  for (std::size_t begin = 0; begin + pattern.size() <= stem.size(); ++begin) {
    std::array<std::string, 6> fields;
    std::string fraction;
    bool fits = true;
    for (std::size_t k = 0; fits && k < pattern.size(); ++k) {
      const char p = pattern[k], c = stem[begin + k];
      const std::size_t field = kFields.find(p);
      if (field != std::string_view::npos || p == 'c') {
        fits = is_digit(c);
        (p == 'c' ? fraction : fields[field]) += c;
      } else {
        fits = p == '?' || p == c;
      }
    }
    if (!fits) continue;
    if (const auto t = assembled(fields, fraction)) return t;
  }
  return std::nullopt;
}

std::optional<Time> utc_from_name(std::string_view stem) {
  for (std::size_t at = 0; at < stem.size(); ++at)
    if ((at == 0 || !is_digit(stem[at - 1])) && is_digit(stem[at]))
      if (const auto t = zulu_at(stem, at)) return t;

  // Seconds since 1970 and their fractions: the one run of digits in the name.
  const std::size_t first = stem.find_first_of("0123456789");
  if (first == std::string_view::npos || stem[first] != '1') return std::nullopt;
  const std::size_t end = std::min(stem.find_first_not_of("0123456789.", first), stem.size());
  if (stem.find_first_of("0123456789", end) != std::string_view::npos) return std::nullopt;
  const std::string_view run = stem.substr(first, end - first);
  const std::size_t dot = run.find('.');
  std::string whole(run.substr(0, dot));
  std::string fraction(dot == std::string_view::npos ? "" : run.substr(dot + 1));
  if (dot == std::string_view::npos &&
      (whole.size() == 13 || whole.size() == 16 || whole.size() == 19)) {
    fraction = whole.substr(10);
    whole.resize(10);
  }
  if (whole.size() != 10 || fraction.size() > 9 || fraction.find('.') != std::string::npos)
    return std::nullopt;
  fraction.resize(9, '0');
  return Time(std::chrono::seconds(std::stoll(whole)) + Duration(std::stoll(fraction)));
}

}  // namespace watersky
