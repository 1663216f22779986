// SPDX-License-Identifier: MIT
#include "watersky/vision/ice_model.hpp"

#include <boost/crc.hpp>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <vector>

#include "watersky/base/contract.hpp"
#include "watersky/vision/detail/dense_network.hpp"
#include "watersky/vision/detail/ice_features.hpp"
#include "watersky/vision/detail/polarity_cues.hpp"
#include "watersky/vision/detail/shipped_model.hpp"

namespace watersky {
namespace {

using detail::DenseLayer;
using detail::DenseNetwork;

constexpr std::string_view kFirstLine = "watersky ice model";
constexpr int kFormatVersion = 1;
constexpr int kMostLayers = 8;
constexpr int kWidest = 256;
constexpr int kOutputs = 3;

std::uint32_t checksum(std::string_view text) {
  boost::crc_32_type crc;
  crc.process_bytes(text.data(), text.size());
  return crc.checksum();
}

template <class Number>
std::string number(Number value, int base = 10) {
  char text[32];
  std::to_chars_result end{};
  if constexpr (std::is_floating_point_v<Number>)
    end = std::to_chars(text, text + sizeof text, value);
  else
    end = std::to_chars(text, text + sizeof text, value, base);
  return {text, end.ptr};
}

void append_row(std::string& text, std::string_view word, const float* values, std::size_t n) {
  text += word;
  for (std::size_t i = 0; i < n; ++i) text += ' ' + number(values[i]);
  text += '\n';
}

void append_network(std::string& text, const std::string& name, const DenseNetwork& network) {
  text += "network " + name + ' ' + number(network.inputs());
  for (const auto& layer : network.layers) text += ' ' + number(layer.outputs);
  text += '\n';
  append_row(text, "mean", network.input_mean.data(), network.input_mean.size());
  append_row(text, "scale", network.input_scale.data(), network.input_scale.size());
  for (const auto& layer : network.layers) {
    const auto inputs = static_cast<std::size_t>(layer.inputs);
    for (std::size_t o = 0; o < layer.biases.size(); ++o)
      append_row(text, "weights", layer.weights.data() + o * inputs, inputs);
    append_row(text, "biases", layer.biases.data(), layer.biases.size());
  }
}

/// Lines and words of a model's text; errors say which line.
class ModelReader {
 public:
  ModelReader(std::string_view text, std::string name) : rest_(text), name_(std::move(name)) {}

  [[nodiscard]] Error error(const std::string& what,
                            ErrorCode code = ErrorCode::InvalidInput) const {
    return {code, name_ + ":" + std::to_string(line_) + ": " + what};
  }

  /// The next line's words.
  Result<std::vector<std::string_view>> next_line() {
    ++line_;
    const auto end = rest_.find('\n');
    if (end == std::string_view::npos)
      return error("the model ends here: it was cut short; copy or train it again");
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(end + 1);
    std::vector<std::string_view> words;
    while (!line.empty()) {
      const auto space = line.find(' ');
      words.push_back(line.substr(0, space));
      line.remove_prefix(space == std::string_view::npos ? line.size() : space + 1);
    }
    return words;
  }

  template <class Number>
  Result<Number> parse(std::string_view word) const {
    Number value{};
    const auto end = std::from_chars(word.data(), word.data() + word.size(), value);
    bool good = end.ec == std::errc() && end.ptr == word.data() + word.size();
    if constexpr (std::is_floating_point_v<Number>) good = good && std::isfinite(value);
    if (!good) return error("'" + std::string(word) + "' is not a number");
    return value;
  }

  Status row(std::string_view word, float* values, std::size_t n) {
    WATERSKY_TRY(const auto words, next_line());
    if (words.size() != n + 1 || words[0] != word)
      return error("expected '" + std::string(word) + "' and " + std::to_string(n) + " numbers");
    for (std::size_t i = 0; i < n; ++i) {
      WATERSKY_TRY(values[i], parse<float>(words[i + 1]));
    }
    return {};
  }

  /// What follows a network's line.
  Result<DenseNetwork> network(const std::vector<std::string_view>& heading, int inputs) {
    if (heading.size() < 5 || heading.size() > 4 + kMostLayers)
      return error("a network has 1 to " + std::to_string(kMostLayers) + " layers");
    std::vector<int> widths;
    for (std::size_t i = 3; i < heading.size(); ++i) {
      WATERSKY_TRY(const int width, parse<int>(heading[i]));
      if (width < 1 || width > kWidest)
        return error("a layer is from 1 to " + std::to_string(kWidest) + " wide, not " +
                     std::to_string(width));
      widths.push_back(width);
    }
    if (widths.front() != inputs || widths.back() != kOutputs)
      return error("the network takes " + std::to_string(widths.front()) + " inputs to " +
                   std::to_string(widths.back()) + " outputs; this program's take " +
                   std::to_string(inputs) + " to " + std::to_string(kOutputs));
    DenseNetwork network;
    network.input_mean.resize(static_cast<std::size_t>(inputs));
    network.input_scale.resize(static_cast<std::size_t>(inputs));
    WATERSKY_CHECK(row("mean", network.input_mean.data(), network.input_mean.size()));
    WATERSKY_CHECK(row("scale", network.input_scale.data(), network.input_scale.size()));
    for (std::size_t l = 1; l < widths.size(); ++l) {
      DenseLayer layer{widths[l - 1], widths[l], {}, {}};
      const auto width = static_cast<std::size_t>(layer.inputs);
      layer.weights.resize(width * static_cast<std::size_t>(layer.outputs));
      layer.biases.resize(static_cast<std::size_t>(layer.outputs));
      for (std::size_t o = 0; o < layer.biases.size(); ++o)
        WATERSKY_CHECK(row("weights", layer.weights.data() + o * width, width));
      WATERSKY_CHECK(row("biases", layer.biases.data(), layer.biases.size()));
      network.layers.push_back(std::move(layer));
    }
    return network;
  }

 private:
  std::string_view rest_;
  std::string name_;
  int line_ = 0;
};

std::string joined(const std::vector<std::string_view>& words, std::size_t first) {
  std::string text;
  for (std::size_t i = first; i < words.size(); ++i)
    text += (i == first ? "" : " ") + std::string(words[i]);
  return text;
}

}  // namespace

std::string format_ice_model(const IceModel& model) {
  std::string text = std::string(kFirstLine) + ' ' + number(kFormatVersion) + '\n';
  text += "features " + number(detail::kIceFeaturesVersion) + '\n';
  const auto append = [&](const std::string& kind, const std::optional<IceNetworks>& networks,
                          const std::string& origin) {
    if (!networks) return;
    text += "origin " + kind + ' ' + origin + '\n';
    if (!networks->polarity.empty()) {
      append_row(text, "polarity", networks->polarity.data(), networks->polarity.size());
      append_row(text, "detail", &networks->detail, 1);
    }
    append_network(text, kind + " coarse", *networks->coarse);
    append_network(text, kind + " fine", *networks->fine);
  };
  append("gray", model.gray, model.gray_origin);
  append("colour", model.colour, model.colour_origin);
  return text + "crc32 " + number(checksum(text), 16) + '\n';
}

Result<IceModel> parse_ice_model(std::string_view text, const std::string& name) {
  ModelReader reader(text, name);
  if (!text.starts_with(kFirstLine))
    return Error{ErrorCode::InvalidInput,
                 name + ": not a Watersky ice model: it should begin with '" +
                     std::string(kFirstLine) + "'; train one with 'watersky segment train'"};
  WATERSKY_TRY(const auto first, reader.next_line());
  if (first.size() != 4 || first[3] != number(kFormatVersion))
    return reader.error("this is version '" + joined(first, 3) +
                            "' of the format, this program reads version " +
                            number(kFormatVersion) + "; train the model again",
                        ErrorCode::Unsupported);
  const auto last = text.rfind("crc32 ");
  if (last == std::string_view::npos || text.back() != '\n' || text[last - 1] != '\n' ||
      text.find('\n', last) != text.size() - 1)
    return Error{ErrorCode::InvalidInput,
                 name +
                     ": the checksum at the end is missing: the model was cut short; copy or "
                     "train it again"};
  if (text.substr(last + 6, text.size() - last - 7) != number(checksum(text.substr(0, last)), 16))
    return Error{ErrorCode::InvalidInput,
                 name + ": its checksum is wrong: the model was damaged; copy or train it again"};
  WATERSKY_TRY(const auto features, reader.next_line());
  if (features.size() != 2 || features[0] != "features" ||
      features[1] != number(detail::kIceFeaturesVersion))
    return reader.error("the model was trained on features of version '" + joined(features, 1) +
                            "', this program has version " + number(detail::kIceFeaturesVersion) +
                            "; train it again",
                        ErrorCode::Unsupported);
  IceModel model;
  model.name = name;
  for (;;) {
    WATERSKY_TRY(const auto heading, reader.next_line());
    if (heading.size() == 2 && heading[0] == "crc32") break;
    if (heading.size() < 2 || heading[0] != "origin" ||
        (heading[1] != "gray" && heading[1] != "colour"))
      return reader.error("expected 'origin gray …' or 'origin colour …'");
    const bool in_colour = heading[1] == "colour";
    (in_colour ? model.colour_origin : model.gray_origin) = joined(heading, 2);
    IceNetworks networks;
    if (!in_colour) {
      networks.polarity.resize(detail::kPolarityCues);
      WATERSKY_CHECK(reader.row("polarity", networks.polarity.data(), networks.polarity.size()));
      WATERSKY_CHECK(reader.row("detail", &networks.detail, 1));
    }
    for (const bool fine : {false, true}) {
      WATERSKY_TRY(const auto line, reader.next_line());
      if (line.size() < 3 || line[0] != "network" || line[1] != heading[1] ||
          line[2] != (fine ? "fine" : "coarse"))
        return reader.error("expected 'network " + std::string(heading[1]) +
                            (fine ? " fine" : " coarse") + " …'");
      WATERSKY_TRY(auto network, reader.network(line, fine ? detail::fine_inputs(in_colour)
                                                           : detail::coarse_inputs(in_colour)));
      (fine ? networks.fine : networks.coarse) =
          std::make_shared<const DenseNetwork>(std::move(network));
    }
    (in_colour ? model.colour : model.gray) = std::move(networks);
  }
  if (!model.gray && !model.colour)
    return Error{ErrorCode::InvalidInput, name + ": the model has no network; train it again"};
  return model;
}

const IceModel& IceModel::shipped() {
  static const IceModel model = [] {
    auto parsed = parse_ice_model(detail::shipped_model_text(), "shipped");
    WATERSKY_REQUIRE(parsed.ok());
    return std::move(parsed).value();
  }();
  return model;
}

}  // namespace watersky
