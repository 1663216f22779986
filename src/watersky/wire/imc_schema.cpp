// SPDX-License-Identifier: MIT
#include "watersky/wire/imc_schema.hpp"

#include <algorithm>
#include <map>

#include "watersky/wire/detail/imc_table.hpp"

namespace watersky::imc {

namespace {

constexpr std::uint16_t kNoMessage = 0xFFFF;

/// "name list<Type> [unit]"
FieldInfo parse_field(std::string_view text) {
  FieldInfo field;
  const std::size_t space = text.find(' ');
  field.name = text.substr(0, space);
  std::string_view rest = text.substr(space + 1);
  if (const std::size_t unit = rest.find(" ["); unit != std::string_view::npos) {
    field.unit = rest.substr(unit + 2, rest.size() - unit - 3);
    rest = rest.substr(0, unit);
  }
  if (const std::size_t type = rest.find('<'); type != std::string_view::npos) {
    field.message_type = rest.substr(type + 1, rest.size() - type - 2);
    rest = rest.substr(0, type);
  }
  const auto* found = std::find_if(std::begin(detail::kTypes), std::end(detail::kTypes),
                                   [&](const detail::TypeName& t) { return t.ours == rest; });
  WATERSKY_REQUIRE(found != std::end(detail::kTypes));
  field.type = found->type;
  return field;
}

template <class Use>
void each_part(std::string_view text, std::string_view separator, Use&& use) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(separator), text.size());
    use(text.substr(0, end));
    text.remove_prefix(std::min(end + separator.size(), text.size()));
  }
}

void place_fields(MessageInfo& message) {
  message.fixed_bytes = 0;
  message.varies = false;
  for (FieldInfo& field : message.fields) {
    field.offset = message.fixed_bytes;
    field.has_offset = !message.varies;
    const std::size_t size = size_bytes(field.type);
    message.fixed_bytes += size;
    message.varies |= size == 0;
  }
}

}  // namespace

std::size_t size_bytes(FieldType type) {
  return detail::kTypes[static_cast<std::size_t>(type)].size;
}

std::size_t MessageInfo::index(std::string_view field_name) const {
  std::size_t i = 0;
  while (i < fields.size() && fields[i].name != field_name) ++i;
  return i;
}

const Schema& Schema::builtin() {
  static const Schema schema = [] {
    std::vector<MessageInfo> messages;
    for (const detail::TableRow& row : detail::table_rows()) {
      MessageInfo message;
      message.id = row.id;
      message.name = row.name;
      each_part(row.fields, "; ",
                [&](std::string_view part) { message.fields.push_back(parse_field(part)); });
      messages.push_back(std::move(message));
    }
    std::vector<MessageGroup> groups;
    for (const detail::GroupRow& row : detail::group_rows()) {
      groups.push_back({std::string(row.name), {}});
      each_part(row.members, " ",
                [&](std::string_view part) { groups.back().members.emplace_back(part); });
    }
    return Schema::make(std::move(messages), groups).value();
  }();
  return schema;
}

const MessageInfo* Schema::find(std::string_view name) const {
  const auto it = std::find_if(messages_.begin(), messages_.end(),
                               [&](const MessageInfo& m) { return m.name == name; });
  return it == messages_.end() ? nullptr : &*it;
}

Result<Schema> Schema::make(std::vector<MessageInfo> messages,
                            const std::vector<MessageGroup>& groups) {
  const auto invalid = [](const std::string& what) {
    return Error{ErrorCode::InvalidInput, "the IMC schema: " + what};
  };
  Schema schema;
  schema.messages_ = std::move(messages);
  std::sort(schema.messages_.begin(), schema.messages_.end(),
            [](const MessageInfo& a, const MessageInfo& b) { return a.id < b.id; });
  if (schema.messages_.empty()) return invalid("holds no message");
  if (schema.messages_.back().id == kNoMessage)
    return invalid(schema.messages_.back().name + " has the id 65535, which means no message");
  schema.by_id_.assign(schema.messages_.back().id + std::size_t{1}, 0);

  std::map<std::string_view, std::vector<std::uint16_t>> ids;
  for (std::size_t i = 0; i < schema.messages_.size(); ++i) {
    MessageInfo& m = schema.messages_[i];
    if (schema.by_id_[m.id] != 0)
      return invalid(m.name + " has the id " + std::to_string(m.id) + " of another message");
    schema.by_id_[m.id] = static_cast<std::uint16_t>(i + 1);
    if (!ids.emplace(m.name, std::vector{m.id}).second) return invalid(m.name + " comes twice");
    if (m.fields.size() > kMaxFields)
      return invalid(m.name + " has " + std::to_string(m.fields.size()) + " fields, more than " +
                     std::to_string(kMaxFields));
    place_fields(m);
  }
  for (const MessageGroup& group : groups) {
    std::vector<std::uint16_t> members;
    for (const std::string& name : group.members) {
      const MessageInfo* member = schema.find(name);
      if (!member)
        return invalid("group " + group.name + " names " + name + ", which is not in it");
      members.push_back(member->id);
    }
    std::sort(members.begin(), members.end());
    if (!ids.emplace(group.name, std::move(members)).second)
      return invalid("the group " + group.name + " has the name of a message or group");
  }
  for (MessageInfo& m : schema.messages_)
    for (std::size_t i = 0; i < m.fields.size(); ++i) {
      FieldInfo& field = m.fields[i];
      if (m.index(field.name) != i) return invalid(m.name + "." + field.name + " comes twice");
      if (field.message_type.empty()) continue;
      const auto accepted = ids.find(field.message_type);
      if (accepted == ids.end())
        return invalid(m.name + "." + field.name + " is of " + field.message_type +
                       ", which is not in it");
      field.accepts = accepted->second;
    }
  return schema;
}

}  // namespace watersky::imc
