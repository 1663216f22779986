// SPDX-License-Identifier: MIT
#include "watersky/wire/dataflash_writer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "watersky/base/contract.hpp"
#include "watersky/wire/detail/dataflash_letters.hpp"

namespace watersky::dataflash {

namespace {

using namespace detail;

/// Numbers of formats that ArduPilot gives away itself begin here.
constexpr std::uint8_t kFirstType = 129;
constexpr std::size_t kMostFormats = 100, kMostLetters = 16, kMostColumns = 64, kMostName = 4;

void put_text(Bytes& out, std::string_view text, std::size_t size) {
  const std::size_t at = out.size();
  out.resize(at + size);
  std::copy_n(text.begin(), std::min(size, text.size()),
              out.begin() + static_cast<std::ptrdiff_t>(at));
}

void put_head(Bytes& out, std::uint8_t type) {
  put(out, kHead1);
  put(out, kHead2);
  put(out, type);
}

void put_format(Bytes& out, std::uint8_t type, std::size_t length, std::string_view name,
                std::string_view letters, std::string_view columns) {
  put_head(out, kFmt);
  put(out, type);
  put(out, static_cast<std::uint8_t>(length));
  put_text(out, name, kMostName);
  put_text(out, letters, kMostLetters);
  put_text(out, columns, kMostColumns);
}

template <class T>
void put_whole(Bytes& out, double value) {
  constexpr double low = static_cast<double>(std::numeric_limits<T>::min());
  constexpr double high = static_cast<double>(std::numeric_limits<T>::max());
  const double whole = std::isnan(value) ? 0.0 : std::round(value);
  put(out, whole <= low    ? std::numeric_limits<T>::min()
           : whole >= high ? std::numeric_limits<T>::max()
                           : static_cast<T>(whole));
}

void put_number(Bytes& out, char letter, double value) {
  const double scale = find_letter(letter)->scale;
  switch (letter) {
    case 'f': return put(out, static_cast<float>(value));
    case 'd': return put(out, value);
    case 'b': return put_whole<std::int8_t>(out, value);
    case 'h':
    case 'c': return put_whole<std::int16_t>(out, value / scale);
    case 'H':
    case 'C': return put_whole<std::uint16_t>(out, value / scale);
    case 'i':
    case 'e':
    case 'L': return put_whole<std::int32_t>(out, value / scale);
    case 'I':
    case 'E': return put_whole<std::uint32_t>(out, value / scale);
    case 'q': return put_whole<std::int64_t>(out, value);
    case 'Q': return put_whole<std::uint64_t>(out, value);
    default: return put_whole<std::uint8_t>(out, value);
  }
}

}  // namespace

Writer::Writer() {
  put_format(bytes_, kFmt, kFmtLength, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns");
}

std::size_t Writer::add_format(std::string_view name, std::string_view letters,
                               std::string_view columns) {
  WATERSKY_REQUIRE(name.size() <= kMostName && !letters.empty() && letters.size() <= kMostLetters &&
                   columns.size() <= kMostColumns && letters_.size() < kMostFormats);
  WATERSKY_REQUIRE(static_cast<std::size_t>(std::count(columns.begin(), columns.end(), ',')) + 1 ==
                   letters.size());
  std::size_t length = kHead;
  for (const char letter : letters) {
    const Letter* known = find_letter(letter);
    WATERSKY_REQUIRE(known != nullptr && known->scale != 0 && letter != 'g');
    length += known->size;
  }
  put_format(bytes_, static_cast<std::uint8_t>(kFirstType + letters_.size()), length, name, letters,
             columns);
  letters_.emplace_back(letters);
  return letters_.size() - 1;
}

void Writer::append(std::size_t format, std::initializer_list<double> values) {
  WATERSKY_REQUIRE(format < letters_.size() && values.size() == letters_[format].size());
  put_head(bytes_, static_cast<std::uint8_t>(kFirstType + format));
  auto letter = letters_[format].begin();
  for (const double value : values) put_number(bytes_, *letter++, value);
}

}  // namespace watersky::dataflash
