// SPDX-License-Identifier: MIT
/// IMC.xml, of which only what decides the bytes is read: messages, their fields, groups.
#include <expat.h>

#include <algorithm>
#include <charconv>
#include <memory>
#include <optional>

#include "watersky/wire/detail/imc_table.hpp"

namespace watersky::imc {

namespace {

constexpr std::size_t kMaxBytes = std::size_t{64} << 20;  // LSTS's is 0.5 MB
constexpr std::size_t kMaxMessages = 0xFFFF;

struct Reading {
  XML_Parser parser = nullptr;
  int depth = 0;  ///< of elements: messages 1, message 2, field 3
  bool is_imc = false;
  std::vector<MessageInfo> messages;
  std::vector<MessageGroup> groups;
  enum class In { Nothing, Message, Groups } in = In::Nothing;
  std::string fault;

  void fail(std::string what) {
    if (!fault.empty()) return;
    fault = "line " + std::to_string(XML_GetCurrentLineNumber(parser)) + ": " + std::move(what);
    XML_StopParser(parser, XML_FALSE);
  }

  void message(const XML_Char** attributes);
  void field(const XML_Char** attributes);
};

std::optional<std::string_view> attribute(const XML_Char** attributes, std::string_view name) {
  for (; *attributes; attributes += 2)
    if (name == attributes[0]) return attributes[1];
  return std::nullopt;
}

void Reading::message(const XML_Char** attributes) {
  const auto id = attribute(attributes, "id"), name = attribute(attributes, "abbrev");
  if (!id || !name) return fail("a message without id or abbrev");
  MessageInfo info;
  const auto [end, error] = std::from_chars(id->data(), id->data() + id->size(), info.id);
  if (error != std::errc{} || end != id->data() + id->size())
    return fail(std::string(*name) + " has the id \"" + std::string(*id) +
                "\", which is no number from 0 to 65534");
  if (messages.size() == kMaxMessages) return fail("more messages than there are ids");
  info.name = *name;
  messages.push_back(std::move(info));
  in = In::Message;
}

void Reading::field(const XML_Char** attributes) {
  const auto name = attribute(attributes, "abbrev"), type = attribute(attributes, "type");
  MessageInfo& info = messages.back();
  if (!name || !type) return fail("a field of " + info.name + " without abbrev or type");
  const auto* known = std::find_if(std::begin(detail::kTypes), std::end(detail::kTypes),
                                   [&](const detail::TypeName& t) { return t.xml == *type; });
  if (known == std::end(detail::kTypes))
    return fail(info.name + "." + std::string(*name) + " is of the unknown type \"" +
                std::string(*type) + "\"");
  if (info.fields.size() == Schema::kMaxFields)
    return fail(info.name + " has more than " + std::to_string(Schema::kMaxFields) + " fields");
  FieldInfo field;
  field.name = *name;
  field.type = known->type;
  field.message_type = attribute(attributes, "message-type").value_or("");
  const auto unit = attribute(attributes, "unit").value_or("");
  // Not units but kinds of values.
  for (const std::string_view kind : {"Enumerated", "Bitfield", "TupleList", "List"})
    if (unit == kind) return info.fields.push_back(std::move(field));
  field.unit = unit;
  info.fields.push_back(std::move(field));
}

void begin_element(void* data, const XML_Char* name, const XML_Char** attributes) {
  auto& reading = *static_cast<Reading*>(data);
  const std::string_view element = name;
  ++reading.depth;
  if (reading.depth == 1) reading.is_imc = element == "messages";
  if (reading.depth == 2 && element == "message") reading.message(attributes);
  if (reading.depth == 2 && element == "message-groups") reading.in = Reading::In::Groups;
  if (reading.depth == 3 && reading.in == Reading::In::Message && element == "field")
    reading.field(attributes);
  if (reading.in == Reading::In::Groups && reading.depth == 3 && element == "message-group")
    reading.groups.push_back({std::string(attribute(attributes, "abbrev").value_or("")), {}});
  if (reading.in == Reading::In::Groups && reading.depth == 4 && element == "message-type" &&
      !reading.groups.empty())
    reading.groups.back().members.emplace_back(attribute(attributes, "abbrev").value_or(""));
}

void end_element(void* data, const XML_Char*) {
  auto& reading = *static_cast<Reading*>(data);
  if (--reading.depth == 1) reading.in = Reading::In::Nothing;
}

}  // namespace

Result<Schema> Schema::from_xml(std::string_view text) {
  const auto invalid = [](const std::string& what) {
    return Error{ErrorCode::InvalidInput, "the IMC schema: " + what};
  };
  if (text.size() > kMaxBytes)
    return invalid(std::to_string(text.size()) + " bytes are too many to be an IMC.xml");
  const std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser(
      XML_ParserCreate(nullptr), XML_ParserFree);
  if (!parser) return Error{ErrorCode::Io, "no memory to read an IMC.xml"};
  Reading reading;
  reading.parser = parser.get();
  XML_SetUserData(parser.get(), &reading);
  XML_SetElementHandler(parser.get(), begin_element, end_element);
  const auto status = XML_Parse(parser.get(), text.data(), static_cast<int>(text.size()), XML_TRUE);
  if (!reading.fault.empty()) return invalid(reading.fault);
  if (status != XML_STATUS_OK)
    return invalid("line " + std::to_string(XML_GetCurrentLineNumber(parser.get())) + ": " +
                   XML_ErrorString(XML_GetErrorCode(parser.get())));
  if (!reading.is_imc) return invalid("its first element is not <messages>; is it an IMC.xml?");
  return make(std::move(reading.messages), reading.groups);
}

}  // namespace watersky::imc
