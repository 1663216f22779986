// SPDX-License-Identifier: MIT
#include "watersky/io/video.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "watersky/io/detail/child_process.hpp"
#include "watersky/io/detail/video_decoder.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/name_time.hpp"

namespace watersky {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// What ffprobe may say about one video: 24 h at 60 Hz are 300 MB.
constexpr std::size_t kMaxProbeBytes = std::size_t{1} << 30;
constexpr int kMaxSide = 1 << 15;
/// Cameras without a clock write 1904 or 1970.
constexpr Time kFirstCredible{std::chrono::seconds(631'152'000)};  // 1990-01-01

Error bad(const fs::path& file, const std::string& what) {
  return {ErrorCode::InvalidInput, file.string() + ": " + what};
}

/// ffprobe's JSON about the first video stream.
Result<json> run_ffprobe(const fs::path& file, const std::string& entries) {
  WATERSKY_TRY(detail::ChildProcess process,
               detail::ChildProcess::start(
                   {"ffprobe", "-hide_banner", "-loglevel", "error", "-protocol_whitelist", "file",
                    "-select_streams", "V:0", "-show_entries", entries, "-of", "json=compact=1",
                    "file:" + file.string()},
                   "ffmpeg"));
  std::string text, complaint;
  const auto on_line = [&](std::string_view line) { complaint = line.substr(0, 160); };
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  for (bool more = true; more;) {
    const std::size_t had = text.size();
    if (had > kMaxProbeBytes) return bad(file, "lists more frames than any flight has");
    text.resize(had + kPiece);
    auto read = process.read({reinterpret_cast<std::uint8_t*>(text.data()) + had, kPiece}, on_line);
    if (!read) return read.error().at(file.string());
    text.resize(had + *read);
    more = *read == kPiece;
  }
  json out = json::parse(text, nullptr, false);
  if (!out.is_object() || !out.contains("streams") || !out["streams"].is_array() ||
      out["streams"].empty())
    return bad(file, "is no video that can be read" +
                         (complaint.empty() ? "" : " (ffprobe: " + complaint + ")"));
  return out;
}

std::string text_of(const json& object, const char* key) {
  const auto it = object.find(key);
  return it != object.end() && it->is_string() ? it->get<std::string>() : std::string();
}

std::optional<std::int64_t> integer_of(const json& object, const char* key) {
  const auto it = object.find(key);
  if (it == object.end()) return std::nullopt;
  if (it->is_number_integer()) return it->get<std::int64_t>();
  if (!it->is_string()) return std::nullopt;
  const std::string& s = it->get_ref<const std::string&>();
  std::int64_t x = 0;
  const auto [end, ec] = std::from_chars(s.data(), s.data() + s.size(), x);
  return ec == std::errc() && end == s.data() + s.size() ? std::optional(x) : std::nullopt;
}

std::optional<Time> creation_time_of(const json& object) {
  const auto tags = object.find("tags");
  if (tags == object.end() || !tags->is_object()) return std::nullopt;
  const auto time = utc_from_name(text_of(*tags, "creation_time"));
  return time && *time > kFirstCredible ? time : std::nullopt;
}

/// What the container lists: nothing when a frame has no time of its own (AVI, fields).
std::vector<VideoFrame> frames_from_packets(const json& packets) {
  std::vector<VideoFrame> frames;
  for (const json& packet : packets) {
    const std::string flags = text_of(packet, "flags");
    if (flags.find('D') != std::string::npos) continue;  // to be decoded but not shown
    const auto pts = integer_of(packet, "pts");
    if (!pts) return {};
    frames.push_back({*pts, flags.find('K') != std::string::npos});
  }
  return frames;
}

std::vector<VideoFrame> frames_from_decoding(const json& decoded) {
  std::vector<VideoFrame> frames;
  for (const json& frame : decoded)
    if (const auto pts = integer_of(frame, "best_effort_timestamp"))
      frames.push_back({*pts, integer_of(frame, "key_frame") == 1});
  return frames;
}

const json& list_of(const json& object, const char* key) {
  static const json none = json::array();
  const auto it = object.find(key);
  return it != object.end() && it->is_array() ? *it : none;
}

Status read_stream(const json& stream, VideoInfo& info) {
  info.stream = static_cast<int>(integer_of(stream, "index").value_or(0));
  const auto width = integer_of(stream, "width").value_or(0),
             height = integer_of(stream, "height").value_or(0);
  if (width <= 0 || height <= 0 || width > kMaxSide || height > kMaxSide)
    return bad(info.path, "says nothing credible about the size of its images");
  info.width_px = static_cast<int>(width);
  info.height_px = static_cast<int>(height);
  info.codec = text_of(stream, "codec_name");
  const std::string pixels = text_of(stream, "pix_fmt");
  info.gray = pixels.starts_with("gray");
  info.sixteen_bit = info.gray && pixels != "gray";
  for (const json& side : list_of(stream, "side_data_list"))
    if (const auto it = side.find("rotation"); it != side.end() && it->is_number())
      info.rotation_deg = it->get<double>();
  info.frames_promised = static_cast<std::size_t>(
      std::max<std::int64_t>(0, integer_of(stream, "nb_frames").value_or(0)));
  info.creation_time = creation_time_of(stream);

  const std::string tick = text_of(stream, "time_base");
  const char* const end = tick.data() + tick.size();
  const auto [slash, ec] = std::from_chars(tick.data(), end, info.tick_numerator);
  const bool divided = ec == std::errc() && slash != end && *slash == '/';
  constexpr std::int64_t kMaxTick = 1'000'000'000;
  if (!divided || std::from_chars(slash + 1, end, info.tick_denominator).ec != std::errc() ||
      info.tick_numerator <= 0 || info.tick_denominator <= 0 || info.tick_numerator > kMaxTick ||
      info.tick_denominator > kMaxTick)
    return bad(info.path, "says nothing credible about its time base");
  return {};
}

}  // namespace

Duration VideoInfo::after_first(std::size_t frame) const {
  WATERSKY_REQUIRE(frame < frames.size());
  // In two steps, so that nothing overflows: probe_video() has seen to it that days fit.
  const std::int64_t since = (frames[frame].pts - frames.front().pts) * tick_numerator;
  const std::int64_t whole = since / tick_denominator, rest = since % tick_denominator;
  return std::chrono::seconds(whole) +
         Duration((rest * 1'000'000'000 + tick_denominator / 2) / tick_denominator);
}

double VideoInfo::rate_hz() const {
  return frames.size() > 1 ? static_cast<double>(frames.size() - 1) / duration_s() : 0.0;
}

bool is_video_file(const fs::path& file) {
  const std::string e = lower_extension(file);
  return e == ".mp4" || e == ".mov" || e == ".mkv" || e == ".avi" || e == ".ts";
}

Result<std::vector<fs::path>> list_videos(const fs::path& folder) {
  return files_with_extension(folder, {".mp4", ".mov", ".mkv", ".avi", ".ts"});
}

Result<VideoInfo> probe_video(const fs::path& file) {
  std::error_code ec;
  if (!fs::exists(file, ec))
    return Error{ErrorCode::NotFound, file.string() + ": there is no such file"};
  if (!fs::is_regular_file(file, ec)) return bad(file, "is not a file");
  const std::string stream_entries =
      "stream=index,codec_name,width,height,pix_fmt,time_base,nb_frames:stream_tags=creation_time:"
      "stream_side_data=rotation:format_tags=creation_time";
  WATERSKY_TRY(const json listed, run_ffprobe(file, stream_entries + ":packet=pts,flags"));
  VideoInfo info;
  info.path = file;
  WATERSKY_CHECK(read_stream(listed["streams"].front(), info));
  if (!info.creation_time && listed.contains("format"))
    info.creation_time = creation_time_of(listed["format"]);

  const json& packets = list_of(listed, "packets");
  info.frames = frames_from_packets(packets);
  // What an edit list hides is there, if not shown.
  if (info.frames_promised <= packets.size()) info.frames_promised = info.frames.size();
  if (info.frames.empty()) {
    info.frames_promised = 0;
    WATERSKY_TRY(const json decoded,
                 run_ffprobe(file, "stream=index:frame=best_effort_timestamp,key_frame"));
    info.frames = frames_from_decoding(list_of(decoded, "frames"));
  }
  if (info.frames.empty()) return bad(file, "holds no frame that can be read; is it cut short?");
  const auto earlier = [](const VideoFrame& a, const VideoFrame& b) { return a.pts < b.pts; };
  std::stable_sort(info.frames.begin(), info.frames.end(), earlier);
  const auto same = [](const VideoFrame& a, const VideoFrame& b) { return a.pts == b.pts; };
  info.frames.erase(std::unique(info.frames.begin(), info.frames.end(), same), info.frames.end());

  constexpr double kLongest_s = 10 * 86'400.0;
  const double span =
      (static_cast<double>(info.frames.back().pts) - static_cast<double>(info.frames.front().pts)) *
      static_cast<double>(info.tick_numerator) / static_cast<double>(info.tick_denominator);
  if (span > kLongest_s)
    return bad(file, "spans more than ten days by its frames' times; it is damaged");
  return info;
}

std::vector<std::size_t> choose_video_frames(const VideoInfo& info, double interval_s) {
  const detail::FrameChoice choice = detail::frame_choice(info, interval_s);
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < info.frames.size(); ++i)
    if (chosen.empty() ||
        choice.run_of(info.frames[i].pts) > choice.run_of(info.frames[chosen.back()].pts))
      chosen.push_back(i);
  return chosen;
}

std::vector<ImageFrame> video_frames(const VideoInfo& info, double interval_s, Time start) {
  const std::vector<std::size_t> chosen = choose_video_frames(info, interval_s);
  const auto decoder =
      std::make_shared<detail::VideoDecoder>(info, detail::frame_choice(info, interval_s), chosen);
  std::vector<ImageFrame> frames;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    ImageFrame frame;
    frame.name = info.path.filename().string() + "#" + std::to_string(chosen[k]);
    frame.captured_at = start + info.after_first(chosen[k]);
    frame.counter = chosen[k];
    frame.load = [decoder, k](const ImageRequest& request) { return decoder->load(k, request); };
    frames.push_back(std::move(frame));
  }
  return frames;
}

}  // namespace watersky
