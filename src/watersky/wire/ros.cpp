// SPDX-License-Identifier: MIT
#include "watersky/wire/ros.hpp"

#include <algorithm>
#include <boost/uuid/detail/md5.hpp>
#include <cstdio>
#include <limits>
#include <set>
#include <type_traits>

#include "watersky/wire/detail/cursor.hpp"

namespace watersky::ros {

namespace {

using watersky::detail::Cursor;

template <class T>
concept Described = requires { T::kType; };
template <class T>
concept HasConstants = requires { T::kConstants; };
template <class T>
concept MayLackItsLast = requires { T::kLastMayBeMissing; };

template <class T>
struct ArrayOf : std::false_type {};
template <class T, std::size_t N>
struct ArrayOf<std::array<T, N>> : std::true_type {
  using Item = T;
};
template <class T>
struct SequenceOf : std::false_type {};
template <class T>
struct SequenceOf<std::vector<T>> : std::true_type {
  using Item = T;
};
template <class T>
struct SequenceOf<std::span<const T>> : std::true_type {
  using Item = T;
};
template <class T>
concept Blob =
    std::same_as<T, std::span<const std::uint8_t>> || std::same_as<T, std::span<const std::int8_t>>;

bool is_in(const FieldInfo& info, Encoding encoding) {
  return (encoding == Encoding::Ros1 ? info.ros1 : info.ros2) != nullptr;
}

template <class T>
T swapped(T value) {
  auto* bytes = reinterpret_cast<std::uint8_t*>(&value);
  std::reverse(bytes, bytes + sizeof value);
  return value;
}

// --- Reading -------------------------------------------------------------------------------

class Reader {
 public:
  Reader(Encoding encoding, std::span<const std::uint8_t> bytes, bool swap, std::size_t most_align)
      : encoding_(encoding), cursor_(bytes), swap_(swap), most_align_(most_align) {}

  template <class T>
  void read(T& value) {
    if constexpr (std::same_as<T, bool>) {
      value = number<std::uint8_t>() != 0;
    } else if constexpr (std::is_arithmetic_v<T>) {
      value = number<T>();
    } else if constexpr (std::same_as<T, Time>) {
      // ROS 2's seconds are signed.
      const std::int64_t s = encoding_ == Encoding::Ros1 ? std::int64_t{number<std::uint32_t>()}
                                                         : std::int64_t{number<std::int32_t>()};
      value = Time(std::chrono::seconds(s) + Duration(number<std::uint32_t>()));
    } else if constexpr (std::same_as<T, std::string>) {
      auto text = cursor_.bytes(number<std::uint32_t>());
      // CDR counts a zero at the end.
      if (encoding_ == Encoding::Cdr && !text.empty() && text.back() == 0)
        text = text.first(text.size() - 1);
      value.assign(text.begin(), text.end());
    } else if constexpr (Blob<T>) {
      const auto bytes = cursor_.bytes(number<std::uint32_t>());
      value = {reinterpret_cast<const typename T::element_type*>(bytes.data()), bytes.size()};
    } else if constexpr (ArrayOf<T>::value) {
      for (auto& item : value) read(item);
    } else if constexpr (SequenceOf<T>::value) {
      // Grown item by item: what is claimed allocates nothing.
      const auto n = number<std::uint32_t>();
      for (std::uint32_t i = 0; i < n && !cursor_.failed(); ++i) {
        typename SequenceOf<T>::Item item{};
        read(item);
        if (!cursor_.failed()) value.push_back(std::move(item));
      }
    } else {
      static_assert(Described<T>);
      T::describe(value, [&](auto& field, const FieldInfo& info) {
        if (!is_in(info, encoding_)) return;
        if constexpr (MayLackItsLast<T>)
          if (!info.ros1 && cursor_.left() == 0) return;
        read(field);
      });
    }
  }

  [[nodiscard]] const Cursor& cursor() const { return cursor_; }

 private:
  template <class T>
  T number() {
    if (encoding_ == Encoding::Cdr) {
      const std::size_t to = std::min(sizeof(T), most_align_);
      (void)cursor_.bytes((to - cursor_.at() % to) % to);
    }
    const T value = cursor_.number<T>();
    return swap_ ? swapped(value) : value;
  }

  Encoding encoding_;
  Cursor cursor_;
  bool swap_;
  std::size_t most_align_;
};

// --- Writing -------------------------------------------------------------------------------

class Writer {
 public:
  explicit Writer(Encoding encoding) : encoding_(encoding) {
    if (encoding == Encoding::Cdr) out_ = {0, 1, 0, 0};  // CDR_LE
    begin_ = out_.size();
  }

  template <class T>
  void write(const T& value) {
    if constexpr (std::same_as<T, bool>) {
      number(static_cast<std::uint8_t>(value));
    } else if constexpr (std::is_arithmetic_v<T>) {
      number(value);
    } else if constexpr (std::same_as<T, Time>) {
      write_time(value);
    } else if constexpr (std::same_as<T, std::string>) {
      const bool zero = encoding_ == Encoding::Cdr;
      number(static_cast<std::uint32_t>(value.size() + (zero ? 1 : 0)));
      watersky::detail::put_bytes(out_, watersky::detail::bytes_of(value));
      if (zero) out_.push_back(0);
    } else if constexpr (Blob<T>) {
      number(static_cast<std::uint32_t>(value.size()));
      watersky::detail::put_bytes(
          out_, {reinterpret_cast<const std::uint8_t*>(value.data()), value.size()});
    } else if constexpr (ArrayOf<T>::value) {
      for (const auto& item : value) write(item);
    } else if constexpr (SequenceOf<T>::value) {
      number(static_cast<std::uint32_t>(value.size()));
      for (const auto& item : value) write(item);
    } else {
      static_assert(Described<T>);
      T::describe(value, [&](const auto& field, const FieldInfo& info) {
        if (is_in(info, encoding_)) write(field);
      });
    }
  }

  [[nodiscard]] Bytes take() { return std::move(out_); }

 private:
  void write_time(Time time) {
    const auto s = std::chrono::floor<std::chrono::seconds>(time.time_since_epoch());
    const auto ns = static_cast<std::uint32_t>((time.time_since_epoch() - s).count());
    if (encoding_ == Encoding::Ros1) {
      number(static_cast<std::uint32_t>(
          std::clamp<std::int64_t>(s.count(), 0, std::numeric_limits<std::uint32_t>::max())));
    } else {
      number(static_cast<std::int32_t>(
          std::clamp<std::int64_t>(s.count(), std::numeric_limits<std::int32_t>::min(),
                                   std::numeric_limits<std::int32_t>::max())));
    }
    number(ns);
  }
  template <class T>
  void number(T value) {
    if (encoding_ == Encoding::Cdr)
      out_.resize(out_.size() + (sizeof(T) - (out_.size() - begin_) % sizeof(T)) % sizeof(T), 0);
    put(out_, value);
  }

  Encoding encoding_;
  Bytes out_;
  std::size_t begin_ = 0;  ///< alignment counts from here
};

// --- Definitions ---------------------------------------------------------------------------

template <class T>
std::string type_name(Encoding encoding) {
  if constexpr (std::same_as<T, bool>) return "bool";
  if constexpr (std::same_as<T, std::uint8_t>) return "uint8";
  if constexpr (std::same_as<T, std::int8_t>) return "int8";
  if constexpr (std::same_as<T, std::uint16_t>) return "uint16";
  if constexpr (std::same_as<T, std::uint32_t>) return "uint32";
  if constexpr (std::same_as<T, float>) return "float32";
  if constexpr (std::same_as<T, double>) return "float64";
  if constexpr (std::same_as<T, std::string>) return "string";
  if constexpr (std::same_as<T, Time>)
    return encoding == Encoding::Ros1 ? "time" : "builtin_interfaces/Time";
  if constexpr (SequenceOf<T>::value)
    return type_name<typename SequenceOf<T>::Item>(encoding) + "[]";
  if constexpr (ArrayOf<T>::value)
    return type_name<typename ArrayOf<T>::Item>(encoding) + "[" +
           std::to_string(std::tuple_size_v<T>) + "]";
  if constexpr (Described<T>) return std::string(T::kType.package) + "/" + T::kType.name;
}

/// Calls `use(constant)` and `use_field(field, name)` in the order of the definition.
template <class M, class UseConstant, class UseField>
void for_lines(Encoding encoding, UseConstant&& use_constant, UseField&& use_field) {
  M message{};
  M::describe(message, [&](auto& field, const FieldInfo& info) {
    if (!is_in(info, encoding)) return;
    const std::string name = encoding == Encoding::Ros1 ? info.ros1 : info.ros2;
    if constexpr (HasConstants<M>)
      for (const Constant& c : M::kConstants)
        if (name == c.before) use_constant(c);
    use_field(field, name);
  });
}

std::string line_of(const Constant& c) {
  return std::string(c.type) + " " + c.name + "=" + c.value + "\n";
}

template <class M>
std::string own_text(Encoding encoding) {
  std::string out;
  for_lines<M>(
      encoding, [&](const Constant& c) { out += line_of(c); },
      [&](auto& field, const std::string& name) {
        out += type_name<std::remove_cvref_t<decltype(field)>>(encoding) + " " + name + "\n";
      });
  return out;
}

/// The message in a field: itself, or what a sequence of it holds; void where there is none.
template <class T>
struct MessageIn {
  using Type = std::conditional_t<Described<T>, T, void>;
};
template <class T>
struct MessageIn<std::vector<T>> {
  using Type = std::conditional_t<Described<T>, T, void>;
};

std::string md5_of(const std::string& text) {
  boost::uuids::detail::md5 md5;
  md5.process_bytes(text.data(), text.size());
  boost::uuids::detail::md5::digest_type digest;
  md5.get_digest(digest);
  // Boost keeps words, their first byte highest.
  static_assert(sizeof digest[0] == 4);
  std::string out;
  char hex[9];
  for (const std::uint32_t word : digest) {
    std::snprintf(hex, sizeof hex, "%08x", static_cast<unsigned>(word));
    out += hex;
  }
  return out;
}

/// ROS 1: the definition without comments, constants first, messages in it replaced by their own
/// sums.
template <class M>
std::string md5sum() {
  std::string constants, fields;
  for_lines<M>(
      Encoding::Ros1, [&](const Constant& c) { constants += line_of(c); },
      [&](auto& field, const std::string& name) {
        using T = std::remove_cvref_t<decltype(field)>;
        using Inner = typename MessageIn<T>::Type;
        if constexpr (std::is_void_v<Inner>)
          fields += type_name<T>(Encoding::Ros1);
        else
          fields += md5sum<Inner>();
        fields += " " + name + "\n";
      });
  std::string text = constants + fields;
  if (!text.empty()) text.pop_back();
  return md5_of(text);
}

/// Appends the definitions of the messages in M that are not there yet.
template <class M>
void append_inner(Encoding encoding, std::set<std::string>& done, std::string& out) {
  const auto append = [&](const std::string& type, const std::string& text) {
    out += std::string(80, '=') + "\nMSG: " + type + "\n" + text;
  };
  for_lines<M>(
      encoding, [](const Constant&) {},
      [&](auto& field, const std::string&) {
        using T = std::remove_cvref_t<decltype(field)>;
        using Inner = typename MessageIn<T>::Type;
        if constexpr (std::same_as<T, Time>) {
          const std::string type = type_name<Time>(encoding);
          if (encoding == Encoding::Cdr && done.insert(type).second)
            append(type, "int32 sec\nuint32 nanosec\n");
        } else if constexpr (!std::is_void_v<Inner>) {
          const std::string type = type_name<Inner>(encoding);
          if (!done.insert(type).second) return;
          append(type, own_text<Inner>(encoding));
          append_inner<Inner>(encoding, done, out);
        }
      });
}

}  // namespace

template <class M>
Result<M> decode(Encoding encoding, std::span<const std::uint8_t> bytes) {
  const std::string type = type_name<M>(encoding);
  bool swap = false;
  std::size_t most_align = 8;
  std::size_t begin = 0;
  if (encoding == Encoding::Cdr) {
    if (bytes.size() < 4)
      return Error{ErrorCode::InvalidInput, type + ": byte 0: is too short for CDR"};
    const int kind = bytes[0] << 8 | bytes[1];
    if (kind != 0 && kind != 1 && kind != 6 && kind != 7)
      return Error{ErrorCode::Unsupported, type + ": byte 0: is in encapsulation " +
                                               std::to_string(kind) +
                                               "; CDR and plain CDR 2 are read"};
    swap = kind % 2 == 0;
    if (kind >= 6) most_align = 4;
    begin = 4;
  }
  Reader reader(encoding, bytes.subspan(begin), swap, most_align);
  M message{};
  reader.read(message);
  if (const Status read = reader.cursor().check("a field"); !read) return read.error().at(type);
  return message;
}

template <class M>
std::vector<std::uint8_t> encode(Encoding encoding, const M& message) {
  Writer writer(encoding);
  writer.write(message);
  return writer.take();
}

template <class M>
Definition definition(Encoding encoding) {
  Definition out;
  out.type = type_name<M>(encoding);
  if (encoding == Encoding::Cdr) out.type = std::string(M::kType.package) + "/msg/" + M::kType.name;
  out.text = own_text<M>(encoding);
  std::set<std::string> done;
  append_inner<M>(encoding, done, out.text);
  if (encoding == Encoding::Ros1) out.md5sum = md5sum<M>();
  return out;
}

#define WATERSKY_ROS_MESSAGE(M)                                          \
  template Result<M> decode<M>(Encoding, std::span<const std::uint8_t>); \
  template std::vector<std::uint8_t> encode<M>(Encoding, const M&);      \
  template Definition definition<M>(Encoding);
WATERSKY_ROS_MESSAGE(Header)
WATERSKY_ROS_MESSAGE(PoseStamped)
WATERSKY_ROS_MESSAGE(TransformStamped)
WATERSKY_ROS_MESSAGE(TFMessage)
WATERSKY_ROS_MESSAGE(Odometry)
WATERSKY_ROS_MESSAGE(OccupancyGrid)
WATERSKY_ROS_MESSAGE(Image)
WATERSKY_ROS_MESSAGE(CompressedImage)
WATERSKY_ROS_MESSAGE(CameraInfo)
WATERSKY_ROS_MESSAGE(NavSatFix)
WATERSKY_ROS_MESSAGE(Imu)
WATERSKY_ROS_MESSAGE(Range)
#undef WATERSKY_ROS_MESSAGE

}  // namespace watersky::ros
