// SPDX-License-Identifier: MIT
#include "watersky/wire/protobuf.hpp"

#include <algorithm>
#include <bit>
#include <map>
#include <type_traits>

#include "watersky/wire/detail/cursor.hpp"
#include "watersky/wire/detail/protobuf_descriptors.hpp"

namespace watersky::protobuf {

namespace {

using detail::FieldType;
using detail::Timestamp;

template <class T>
concept Described = requires { T::kType; };
template <class T>
concept Blob = std::same_as<T, std::span<const std::uint8_t>>;

template <class T>
struct Wrapped {
  static constexpr bool kOptional = false, kVector = false, kArray = false;
  using Item = T;
};
template <class T>
struct Wrapped<std::optional<T>> {
  static constexpr bool kOptional = true, kVector = false, kArray = false;
  using Item = T;
};
template <class T>
struct Wrapped<std::vector<T>> {
  static constexpr bool kOptional = false, kVector = true, kArray = false;
  using Item = T;
};
template <class T, std::size_t N>
struct Wrapped<std::array<T, N>> {
  static constexpr bool kOptional = false, kVector = false, kArray = true;
  using Item = T;
};

enum Wire : std::uint32_t { kVarint = 0, kI64 = 1, kLengthDelimited = 2, kI32 = 5 };

Timestamp timestamp_of(Time time) {
  const auto s = std::chrono::floor<std::chrono::seconds>(time.time_since_epoch());
  return {s.count(), static_cast<std::int32_t>((time.time_since_epoch() - s).count())};
}
Time time_of(const Timestamp& t) {
  constexpr std::int64_t kMost_s = 9'000'000'000;  // Time ends in 2262
  return Time(std::chrono::seconds(std::clamp(t.seconds, -kMost_s, kMost_s)) + Duration(t.nanos));
}

// --- Writing -------------------------------------------------------------------------------

void put_varint(Bytes& out, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7) out.push_back(static_cast<std::uint8_t>(value | 0x80));
  out.push_back(static_cast<std::uint8_t>(value));
}

template <Described M>
void put_message(Bytes& out, const M& message);

void put_tag(Bytes& out, std::int32_t number, Wire wire) {
  put_varint(out, static_cast<std::uint64_t>(number) << 3 | wire);
}

void put_delimited(Bytes& out, std::int32_t number, std::span<const std::uint8_t> bytes) {
  put_tag(out, number, kLengthDelimited);
  put_varint(out, bytes.size());
  watersky::detail::put_bytes(out, bytes);
}

/// One item; scalars are written whatever their value.
template <class T>
void put_item(Bytes& out, std::int32_t number, const T& value) {
  if constexpr (std::same_as<T, std::string>) {
    put_delimited(out, number, watersky::detail::bytes_of(value));
  } else if constexpr (Blob<T>) {
    put_delimited(out, number, value);
  } else if constexpr (std::same_as<T, Time>) {
    put_item(out, number, timestamp_of(value));
  } else if constexpr (Described<T>) {
    Bytes inner;
    put_message(inner, value);
    put_delimited(out, number, inner);
  } else if constexpr (std::same_as<T, double>) {
    put_tag(out, number, kI64);
    put(out, value);
  } else if constexpr (std::same_as<T, std::uint32_t>) {
    put_tag(out, number, kI32);
    put(out, value);
  } else {  // bool, enumerations and the other whole numbers
    put_tag(out, number, kVarint);
    put_varint(out, static_cast<std::uint64_t>(static_cast<std::int64_t>(value)));
  }
}

/// Whether proto3 leaves it away.
template <class T>
bool is_default(const T& value) {
  if constexpr (std::same_as<T, std::string> || Blob<T>) {
    return value.empty();
  } else if constexpr (std::same_as<T, double>) {
    return std::bit_cast<std::uint64_t>(value) == 0;  // -0.0 is a value
  } else if constexpr (Described<T> || std::same_as<T, Time>) {
    return false;
  } else {
    return value == T{};
  }
}

template <Described M>
void put_message(Bytes& out, const M& message) {
  M::describe(message, [&](const auto& field, const FieldInfo& info) {
    using T = std::remove_cvref_t<decltype(field)>;
    using W = Wrapped<T>;
    if constexpr (W::kOptional) {
      if (field) put_item(out, info.number, *field);
    } else if constexpr ((W::kVector || W::kArray) && std::same_as<typename W::Item, double>) {
      if (field.empty()) return;
      Bytes packed;
      for (const double x : field) put(packed, x);
      put_delimited(out, info.number, packed);
    } else if constexpr (W::kVector) {
      for (const auto& item : field) put_item(out, info.number, item);
    } else if (!is_default(field)) {
      put_item(out, info.number, field);
    }
  });
}

// --- Reading -------------------------------------------------------------------------------

class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : all_(bytes) {}

  template <Described M>
  Status read(std::span<const std::uint8_t> bytes, M& message) {
    watersky::detail::Cursor c(bytes);
    while (c.left() > 0) {
      const std::size_t begin = c.at();
      WATERSKY_TRY(const std::uint64_t tag, varint(c, bytes));
      Value value;
      value.wire = static_cast<std::uint32_t>(tag & 7);
      switch (value.wire) {
        case kVarint: {
          WATERSKY_TRY(value.number, varint(c, bytes));
          break;
        }
        case kI64: value.number = c.number<std::uint64_t>(); break;
        case kI32: value.number = c.number<std::uint32_t>(); break;
        case kLengthDelimited: {
          WATERSKY_TRY(const std::uint64_t size, varint(c, bytes));
          value.bytes = c.bytes(size);
          break;
        }
        default: return bad(bytes, begin, "a field of wire type " + std::to_string(value.wire));
      }
      if (c.failed()) return bad(bytes, begin, "a field that is longer than what is left");
      Status status;
      M::describe(message, [&](auto& field, const FieldInfo& info) {
        if (status && (tag >> 3) == static_cast<std::uint64_t>(info.number))
          status = take(field, value, bytes, begin);
      });
      WATERSKY_CHECK(status);
    }
    return {};
  }

 private:
  struct Value {
    std::uint32_t wire = 0;
    std::uint64_t number = 0;
    std::span<const std::uint8_t> bytes;
  };

  [[nodiscard]] Error bad(std::span<const std::uint8_t> in, std::size_t at,
                          const std::string& what) const {
    const auto offset = in.empty() ? at : static_cast<std::size_t>(in.data() - all_.data()) + at;
    return {ErrorCode::InvalidInput, "byte " + std::to_string(offset) + ": " + what};
  }

  Result<std::uint64_t> varint(watersky::detail::Cursor& c,
                               std::span<const std::uint8_t> bytes) const {
    std::uint64_t value = 0;
    const std::size_t begin = c.at();
    for (int shift = 0; shift < 64; shift += 7) {
      const auto byte = c.number<std::uint8_t>();
      if (c.failed()) return bad(bytes, begin, "a number is cut short");
      value |= std::uint64_t{byte & 0x7Fu} << shift;
      if (byte < 0x80) return value;
    }
    return bad(bytes, begin, "a number is longer than ten bytes");
  }

  template <class T>
  Status take(T& field, const Value& value, std::span<const std::uint8_t> in, std::size_t at) {
    using W = Wrapped<T>;
    if constexpr (W::kOptional) {
      if (!field) field.emplace();
      return take(*field, value, in, at);
    } else if constexpr (W::kVector || W::kArray) {
      if constexpr (std::same_as<typename W::Item, double>) {
        if (value.wire != kLengthDelimited || value.bytes.size() % 8 != 0)
          return bad(in, at, "a list of doubles that is none");
        const std::size_t n = value.bytes.size() / 8;
        if constexpr (W::kArray) {
          if (n != field.size())
            return bad(in, at,
                       "a list of " + std::to_string(n) + " doubles instead of " +
                           std::to_string(field.size()));
        } else {
          field.resize(n);
        }
        for (std::size_t i = 0; i < n; ++i) field[i] = number_at<double>(value.bytes, 8 * i);
        return {};
      } else {
        return take(field.emplace_back(), value, in, at);
      }
    } else if constexpr (std::same_as<T, std::string> || Blob<T>) {
      if (value.wire != kLengthDelimited) return bad(in, at, "a field of another type");
      if constexpr (Blob<T>)
        field = value.bytes;
      else
        field.assign(value.bytes.begin(), value.bytes.end());
      return {};
    } else if constexpr (std::same_as<T, Time>) {
      if (value.wire != kLengthDelimited) return bad(in, at, "a field of another type");
      Timestamp t;
      WATERSKY_CHECK(read(value.bytes, t));
      field = time_of(t);
      return {};
    } else if constexpr (Described<T>) {
      if (value.wire != kLengthDelimited) return bad(in, at, "a field of another type");
      return read(value.bytes, field);
    } else if constexpr (std::same_as<T, double>) {
      if (value.wire != kI64) return bad(in, at, "a field of another type");
      field = std::bit_cast<double>(value.number);
      return {};
    } else if constexpr (std::same_as<T, std::uint32_t>) {
      if (value.wire != kI32) return bad(in, at, "a field of another type");
      field = static_cast<std::uint32_t>(value.number);
      return {};
    } else if constexpr (std::is_enum_v<T>) {
      if (value.wire != kVarint) return bad(in, at, "a field of another type");
      // A value of a later version is the unknown one.
      const bool known = value.number < enum_info(T{}).values.size();
      field = static_cast<T>(known ? value.number : 0);
      return {};
    } else {
      if (value.wire != kVarint) return bad(in, at, "a field of another type");
      field = static_cast<T>(value.number);
      return {};
    }
  }

  std::span<const std::uint8_t> all_;
};

// --- Descriptors ---------------------------------------------------------------------------

template <Described M>
std::string full_name() {
  return std::string(M::kType.package) + "." + M::kType.name;
}

using Files = std::map<std::string, detail::FileDescriptor>;  ///< by package

template <Described M>
void add_message(Files& files);

template <class T, Described In>
void describe_type(detail::FieldDescriptor& out, detail::MessageDescriptor& message, Files& files) {
  const auto set = [&](FieldType type) { out.type = static_cast<std::int32_t>(type); };
  if constexpr (std::same_as<T, Time>) {
    describe_type<Timestamp, In>(out, message, files);
  } else if constexpr (Described<T>) {
    set(FieldType::Message);
    out.type_name = "." + full_name<T>();
    add_message<T>(files);
    if (std::string(T::kType.package) != In::kType.package) {
      auto& dependency = files[In::kType.package].dependency;
      const std::string& name = files[T::kType.package].name;
      if (std::find(dependency.begin(), dependency.end(), name) == dependency.end())
        dependency.push_back(name);
    }
  } else if constexpr (std::is_enum_v<T>) {
    set(FieldType::Enum);
    constexpr auto info = enum_info(T{});
    out.type_name = "." + full_name<In>() + "." + info.name;
    detail::EnumDescriptor described{info.name, {}};
    for (std::size_t i = 0; i < info.values.size(); ++i)
      described.value.push_back({info.values[i], static_cast<std::int32_t>(i)});
    message.enum_type.push_back(std::move(described));
  } else if constexpr (std::same_as<T, std::string>) {
    set(FieldType::String);
  } else if constexpr (Blob<T>) {
    set(FieldType::Bytes);
  } else if constexpr (std::same_as<T, double>) {
    set(FieldType::Double);
  } else if constexpr (std::same_as<T, bool>) {
    set(FieldType::Bool);
  } else if constexpr (std::same_as<T, std::uint32_t>) {
    set(FieldType::Fixed32);
  } else if constexpr (std::same_as<T, std::uint64_t>) {
    set(FieldType::Uint64);
  } else if constexpr (std::same_as<T, std::int64_t>) {
    set(FieldType::Int64);
  } else {
    static_assert(std::same_as<T, std::int32_t>);
    set(FieldType::Int32);
  }
}

template <Described M>
void add_message(Files& files) {
  const std::string package = M::kType.package;
  detail::FileDescriptor& file = files[package];
  if (file.name.empty()) {
    file.package = package;
    file.name = package == "google.protobuf" ? "google/protobuf/timestamp.proto"
                                             : package + "/" + package + ".proto";
  }
  for (const auto& there : file.message_type)
    if (there.name == M::kType.name) return;
  detail::MessageDescriptor message;
  message.name = M::kType.name;
  M none{};
  M::describe(none, [&](const auto& field, const FieldInfo& info) {
    using W = Wrapped<std::remove_cvref_t<decltype(field)>>;
    detail::FieldDescriptor described;
    described.name = info.name;
    described.number = info.number;
    described.label = W::kVector || W::kArray ? detail::kLabelRepeated : detail::kLabelOptional;
    describe_type<typename W::Item, M>(described, message, files);
    message.field.push_back(std::move(described));
  });
  files[package].message_type.push_back(std::move(message));
}

}  // namespace

template <class M>
Result<M> decode(std::span<const std::uint8_t> bytes) {
  M message{};
  if (const Status read = Reader(bytes).read(bytes, message); !read)
    return read.error().at(full_name<M>());
  return message;
}

template <class M>
std::vector<std::uint8_t> encode(const M& message) {
  Bytes out;
  put_message(out, message);
  return out;
}

template <class M>
Schema schema() {
  Files files;
  add_message<M>(files);
  detail::FileDescriptorSet set;
  // Readers that go from the first to the last want what others depend on first.
  for (const char* package : {"google.protobuf", "foxglove", "watersky"})
    if (const auto at = files.find(package); at != files.end()) set.file.push_back(at->second);
  return {full_name<M>(), encode(set)};
}

#define WATERSKY_PROTOBUF_MESSAGE(M)                           \
  template Result<M> decode<M>(std::span<const std::uint8_t>); \
  template std::vector<std::uint8_t> encode<M>(const M&);      \
  template Schema schema<M>();
WATERSKY_PROTOBUF_MESSAGE(foxglove::LocationFix)
WATERSKY_PROTOBUF_MESSAGE(foxglove::FrameTransform)
WATERSKY_PROTOBUF_MESSAGE(foxglove::FrameTransforms)
WATERSKY_PROTOBUF_MESSAGE(foxglove::CompressedImage)
WATERSKY_PROTOBUF_MESSAGE(foxglove::RawImage)
WATERSKY_PROTOBUF_MESSAGE(foxglove::CameraCalibration)
WATERSKY_PROTOBUF_MESSAGE(foxglove::Grid)
WATERSKY_PROTOBUF_MESSAGE(foxglove::GeoJSON)
WATERSKY_PROTOBUF_MESSAGE(recording::Pose)
WATERSKY_PROTOBUF_MESSAGE(recording::Frame)
WATERSKY_PROTOBUF_MESSAGE(recording::Gimbal)
WATERSKY_PROTOBUF_MESSAGE(recording::Range)
#undef WATERSKY_PROTOBUF_MESSAGE

}  // namespace watersky::protobuf
