// SPDX-License-Identifier: MIT
#include "watersky/wire/dataflash.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "watersky/base/bytes.hpp"
#include "watersky/wire/detail/dataflash_letters.hpp"

namespace watersky::dataflash {

using namespace detail;

namespace {

/// IEEE 754 half precision.
double half(std::uint16_t bits) {
  const int exponent = bits >> 10 & 0x1F, fraction = bits & 0x3FF;
  const double magnitude = exponent == 0      ? std::ldexp(fraction, -24)
                           : exponent == 0x1F ? (fraction == 0 ? INFINITY : NAN)
                                              : std::ldexp(1024 + fraction, exponent - 25);
  return (bits & 0x8000) != 0 ? -magnitude : magnitude;
}

/// Calls `use` with the number of a letter's C++ type at `at`.
template <class Use>
auto with_number(char letter, std::span<const std::uint8_t> payload, std::size_t at, Use&& use) {
  switch (letter) {
    case 'b': return use(number_at<std::int8_t>(payload, at));
    case 'h':
    case 'c': return use(number_at<std::int16_t>(payload, at));
    case 'H':
    case 'C': return use(number_at<std::uint16_t>(payload, at));
    case 'i':
    case 'e':
    case 'L': return use(number_at<std::int32_t>(payload, at));
    case 'I':
    case 'E': return use(number_at<std::uint32_t>(payload, at));
    case 'q': return use(number_at<std::int64_t>(payload, at));
    case 'Q': return use(number_at<std::uint64_t>(payload, at));
    case 'f': return use(number_at<float>(payload, at));
    case 'd': return use(number_at<double>(payload, at));
    case 'g': return use(half(number_at<std::uint16_t>(payload, at)));
    default: return use(number_at<std::uint8_t>(payload, at));
  }
}

std::string_view text_at(std::span<const std::uint8_t> payload, std::size_t at, std::size_t size) {
  const auto bytes = payload.subspan(at, size);
  const auto end = std::find(bytes.begin(), bytes.end(), 0);
  return {reinterpret_cast<const char*>(bytes.data()),
          static_cast<std::size_t>(end - bytes.begin())};
}

/// The format that an FMT record describes.
Format described(std::span<const std::uint8_t> payload) {
  Format format;
  format.type = payload[0];
  format.length = payload[1];
  format.name = text_at(payload, 2, 4);
  const std::string_view letters = text_at(payload, 6, 16);
  std::string_view names = text_at(payload, 22, 64);
  std::size_t offset = 0;
  for (const char letter : letters) {
    const Letter* known = find_letter(letter);
    const std::size_t comma = std::min(names.find(','), names.size());
    if (!known || comma == 0) return {format.type, format.name, format.length, {}};
    format.fields.push_back({std::string(names.substr(0, comma)), letter, offset, "", 1.0});
    offset += known->size;
    names.remove_prefix(std::min(comma + 1, names.size()));
  }
  if (offset + kHead != format.length || !names.empty()) format.fields.clear();
  return format;
}

/// What every log is to begin with: FMT describes itself.
const Format& fmt() {
  static const Format format{kFmt,
                             "FMT",
                             kFmtLength,
                             {{"Type", 'B', 0, "", 1.0},
                              {"Length", 'B', 1, "", 1.0},
                              {"Name", 'n', 2, "", 1.0},
                              {"Format", 'N', 6, "", 1.0},
                              {"Columns", 'Z', 22, "", 1.0}}};
  return format;
}

}  // namespace

std::size_t Format::index(std::string_view field_name) const {
  std::size_t i = 0;
  while (i < fields.size() && fields[i].name != field_name) ++i;
  return i;
}

double Record::number(std::size_t field) const {
  WATERSKY_REQUIRE(field < format->fields.size());
  const Field& f = format->fields[field];
  const double scale = find_letter(f.type)->scale;
  WATERSKY_REQUIRE(scale != 0);
  return scale * with_number(f.type, payload, f.offset,
                             [](auto value) { return static_cast<double>(value); });
}

std::int64_t Record::integer(std::string_view field) const {
  const std::size_t i = format->index(field);
  WATERSKY_REQUIRE(i < format->fields.size());
  const Field& f = format->fields[i];
  WATERSKY_REQUIRE(find_letter(f.type)->scale != 0 && f.type != 'f' && f.type != 'd' &&
                   f.type != 'g');
  return with_number(f.type, payload, f.offset, [](auto value) -> std::int64_t {
    if constexpr (std::is_floating_point_v<decltype(value)>)
      return 0;
    else
      return static_cast<std::int64_t>(value);
  });
}

std::string_view Record::text(std::string_view field) const {
  const std::size_t i = format->index(field);
  WATERSKY_REQUIRE(i < format->fields.size());
  const Field& f = format->fields[i];
  WATERSKY_REQUIRE(find_letter(f.type)->scale == 0 && f.type != 'a');
  return text_at(payload, f.offset, find_letter(f.type)->size);
}

std::vector<Format> Reader::formats() const {
  std::vector<Format> all;
  for (const auto& format : formats_) {
    if (!format) continue;
    all.push_back(*format);
    if (!field_units_[format->type]) continue;
    const auto& [units, multipliers] = *field_units_[format->type];
    for (std::size_t i = 0; i < all.back().fields.size(); ++i) {
      Field& field = all.back().fields[i];
      if (i < units.size()) field.unit = unit_labels_[static_cast<std::uint8_t>(units[i])];
      const bool scaled_by_letter = find_letter(field.type)->scale != 1;
      if (i >= multipliers.size() || scaled_by_letter) continue;
      const auto& told = multipliers_[static_cast<std::uint8_t>(multipliers[i])];
      // '-' and '?' are told as 0: nothing is known.
      if (told && *told != 0) field.multiplier = *told;
    }
  }
  return all;
}

bool Reader::head_may_stand(std::size_t at) const {
  const auto rest = bytes_.subspan(std::min(at, bytes_.size()));
  return (rest.size() < 1 || rest[0] == kHead1) && (rest.size() < 2 || rest[1] == kHead2) &&
         (rest.size() < 3 || rest[2] == kFmt || formats_[rest[2]]);
}

Reader::Check Reader::check(std::size_t at) const {
  if (!head_may_stand(at)) return Check::No;
  const auto rest = bytes_.subspan(at);
  if (rest.size() < kHead) return Check::CutShort;
  const std::size_t length = rest[2] == kFmt ? kFmtLength : formats_[rest[2]]->length;
  if (rest.size() < length) return Check::CutShort;
  // Where a record was due its head is enough; elsewhere its successor has to vouch for it.
  return at == at_ || head_may_stand(at + length) ? Check::Record : Check::No;
}

std::optional<Record> Reader::next() {
  bool cut = false;
  for (std::size_t at = at_; at < bytes_.size(); ++at) {
    const Check found = check(at);
    if (found == Check::CutShort && at == at_) cut = true;
    if (found != Check::Record) continue;
    if (at > at_ && gaps_++ == 0) first_gap_at_ = at_;
    skipped_ += at - at_;
    const std::uint8_t type = bytes_[at + 2];
    const Format& format = type == kFmt ? fmt() : *formats_[type];
    const Record record{&format, at, bytes_.subspan(at + kHead, format.length - kHead)};
    at_ = at + format.length;
    learn(record);
    return record;
  }
  if (cut) {
    truncated_ = bytes_.size() - at_;
  } else if (at_ < bytes_.size()) {
    if (gaps_++ == 0) first_gap_at_ = at_;
    skipped_ += bytes_.size() - at_;
  }
  at_ = bytes_.size();
  return std::nullopt;
}

void Reader::learn(const Record& record) {
  const Format& format = *record.format;
  const auto has = [&](std::initializer_list<std::string_view> names) {
    return std::all_of(names.begin(), names.end(),
                       [&](std::string_view name) { return format.has(name); });
  };
  const auto is_text = [&](std::string_view name) {
    const char type = format.fields[format.index(name)].type;
    return type == 'n' || type == 'N' || type == 'Z';
  };
  const auto is_number = [&](std::string_view name) {
    return find_letter(format.fields[format.index(name)].type)->scale != 0;
  };
  if (&format == &fmt()) {
    Format told = described(record.payload);
    // A head alone is a record, but one that is shorter would not move the reader on. FMT's own
    // layout cannot change: it is how the others are told.
    if (told.length < kHead || told.type == kFmt) return;
    formats_[told.type] = std::move(told);
  } else if (format.name == "FMTU" && has({"FmtType", "UnitIds", "MultIds"}) &&
             is_number("FmtType") && is_text("UnitIds") && is_text("MultIds")) {
    const auto type =
        static_cast<std::uint8_t>(record.payload[format.fields[format.index("FmtType")].offset]);
    field_units_[type] = {std::string(record.text("UnitIds")), std::string(record.text("MultIds"))};
  } else if (format.name == "UNIT" && has({"Id", "Label"}) && is_number("Id") && is_text("Label")) {
    unit_labels_[record.payload[format.fields[format.index("Id")].offset]] = record.text("Label");
  } else if (format.name == "MULT" && has({"Id", "Mult"}) && is_number("Id") && is_number("Mult")) {
    multipliers_[record.payload[format.fields[format.index("Id")].offset]] = record.number("Mult");
  }
}

Error no_format_error(std::span<const std::uint8_t> bytes) {
  if (bytes.size() >= kHead && bytes[0] == kHead1 && bytes[1] == kHead2)
    return {ErrorCode::InvalidInput,
            "byte 0: a record of type " + std::to_string(bytes[2]) +
                ", but no FMT record says what that is; give the log whole, from its beginning"};
  return {ErrorCode::InvalidInput, "byte 0: a DataFlash log begins with a3 95; is it one?"};
}

}  // namespace watersky::dataflash
