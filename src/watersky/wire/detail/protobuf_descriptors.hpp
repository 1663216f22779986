// SPDX-License-Identifier: MIT
#pragma once
/// google/protobuf/descriptor.proto, as much of it as our schemas need, and Timestamp.
#include <string>
#include <vector>

#include "watersky/wire/protobuf_fields.hpp"

namespace watersky::protobuf::detail {

enum class FieldType : std::int32_t {
  Double = 1,
  Int64 = 3,
  Uint64 = 4,
  Int32 = 5,
  Fixed32 = 7,
  Bool = 8,
  String = 9,
  Message = 11,
  Bytes = 12,
  Enum = 14
};

inline constexpr std::int32_t kLabelOptional = 1;
inline constexpr std::int32_t kLabelRepeated = 3;

struct Timestamp {
  std::int64_t seconds = 0;
  std::int32_t nanos = 0;

  static constexpr TypeName kType{"google.protobuf", "Timestamp"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.seconds, FieldInfo{1, "seconds"});
    field(m.nanos, FieldInfo{2, "nanos"});
  }
};

struct FieldDescriptor {
  std::string name;
  std::int32_t number = 0, label = kLabelOptional, type = 0;
  std::string type_name;  ///< of messages and enumerations: ".package.Name"

  static constexpr TypeName kType{"google.protobuf", "FieldDescriptorProto"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.name, FieldInfo{1, "name"});
    field(m.number, FieldInfo{3, "number"});
    field(m.label, FieldInfo{4, "label"});
    field(m.type, FieldInfo{5, "type"});
    field(m.type_name, FieldInfo{6, "type_name"});
  }
};

struct EnumValueDescriptor {
  std::string name;
  std::int32_t number = 0;

  static constexpr TypeName kType{"google.protobuf", "EnumValueDescriptorProto"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.name, FieldInfo{1, "name"});
    field(m.number, FieldInfo{2, "number"});
  }
};

struct EnumDescriptor {
  std::string name;
  std::vector<EnumValueDescriptor> value;

  static constexpr TypeName kType{"google.protobuf", "EnumDescriptorProto"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.name, FieldInfo{1, "name"});
    field(m.value, FieldInfo{2, "value"});
  }
};

struct MessageDescriptor {
  std::string name;
  std::vector<FieldDescriptor> field;
  std::vector<EnumDescriptor> enum_type;

  static constexpr TypeName kType{"google.protobuf", "DescriptorProto"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.name, FieldInfo{1, "name"});
    field(m.field, FieldInfo{2, "field"});
    field(m.enum_type, FieldInfo{4, "enum_type"});
  }
};

struct FileDescriptor {
  std::string name, package;
  std::vector<std::string> dependency;
  std::vector<MessageDescriptor> message_type;
  std::string syntax = "proto3";

  static constexpr TypeName kType{"google.protobuf", "FileDescriptorProto"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.name, FieldInfo{1, "name"});
    field(m.package, FieldInfo{2, "package"});
    field(m.dependency, FieldInfo{3, "dependency"});
    field(m.message_type, FieldInfo{4, "message_type"});
    field(m.syntax, FieldInfo{12, "syntax"});
  }
};

struct FileDescriptorSet {
  std::vector<FileDescriptor> file;

  static constexpr TypeName kType{"google.protobuf", "FileDescriptorSet"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.file, FieldInfo{1, "file"});
  }
};

}  // namespace watersky::protobuf::detail
