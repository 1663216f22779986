// SPDX-License-Identifier: MIT
#include "watersky/io/detail/video_decoder.hpp"

#include <algorithm>
#include <charconv>
#include <cinttypes>
#include <cmath>
#include <cstdio>

#include "watersky/io/csv.hpp"

namespace watersky::detail {

namespace {

/// Two forms at once: what the polarity is judged from, and what is mapped.
constexpr std::size_t kStreams = 2;
/// Threads take frames a little out of order.
constexpr std::size_t kKept = 8;
constexpr std::size_t kKeptBytes = std::size_t{256} << 20;
/// A complaint is about one of the next frames, but ffmpeg's threads (16 at most, and one in hand)
/// decode ahead of what it writes.
constexpr std::size_t kDecodedAhead = 17;
/// Filters pass a frame on before they take the next; a few more do no harm.
constexpr std::size_t kRemembered = 64;
/// Fewer frames than this are sooner decoded than sought.
constexpr std::size_t kSeekBeyond = 8;
/// A seek that lands too late is repeated this much earlier, then the video is read from its start.
constexpr double kSeekEarlier_s = 5.0;

/// The number behind `key` in one of showinfo's lines.
std::optional<std::int64_t> number_after(std::string_view line, std::string_view key) {
  const std::size_t at = line.find(key);
  if (at == std::string_view::npos) return std::nullopt;
  line.remove_prefix(at + key.size());
  while (!line.empty() && line.front() == ' ') line.remove_prefix(1);
  std::int64_t x = 0;
  const auto [end, ec] = std::from_chars(line.data(), line.data() + line.size(), x);
  return ec == std::errc() ? std::optional(x) : std::nullopt;
}

int blocks(int size_px, int n) { return (size_px + n - 1) / n; }

}  // namespace

FrameChoice frame_choice(const VideoInfo& info, double interval_s) {
  const double ticks = interval_s * static_cast<double>(info.tick_denominator) /
                       static_cast<double>(info.tick_numerator);
  return {info.frames.front().pts, ticks > 1.0 ? ticks : 0.0};
}

double FrameChoice::run_of(std::int64_t pts) const {
  const double since = static_cast<double>(pts - first_pts);
  return interval_ticks > 0 ? std::floor((since + 0.5) / interval_ticks) : since;
}

std::string FrameChoice::expression(std::int64_t from_pts) const {
  const std::string from = "gte(pts," + std::to_string(from_pts) + ")";
  if (!(interval_ticks > 0)) return from;
  const auto run = [this](const char* pts) {
    return std::string("floor((") + pts + "-(" + std::to_string(first_pts) + ")+0.5)/" +
           format_number(interval_ticks) + ")";
  };
  return from + "*(isnan(prev_selected_pts)+gt(" + run("pts") + "," + run("prev_selected_pts") +
         "))";
}

std::string VideoDecoder::name(std::size_t k) const {
  return info_.path.string() + "#" + std::to_string(chosen_[k]);
}

std::optional<std::size_t> VideoDecoder::frame_with(std::int64_t pts) const {
  const auto at = std::lower_bound(info_.frames.begin(), info_.frames.end(), pts,
                                   [](const VideoFrame& f, std::int64_t t) { return f.pts < t; });
  if (at == info_.frames.end() || at->pts != pts) return std::nullopt;
  return static_cast<std::size_t>(at - info_.frames.begin());
}

bool VideoDecoder::key_between(std::size_t after, std::size_t upto) const {
  for (std::size_t i = after + 1; i <= upto; ++i)
    if (info_.frames[i].key) return true;
  return false;
}

cv::Mat VideoDecoder::kept(std::size_t k, const Form& form) const {
  for (const Kept& entry : kept_)
    if (entry.k == k && entry.form == form) return entry.image;
  return {};
}

void VideoDecoder::keep(std::size_t k, const Form& form, cv::Mat image) {
  kept_.push_back({k, form, std::move(image)});
  const auto bytes = [this] {
    std::size_t sum = 0;
    for (const Kept& entry : kept_) sum += entry.image.total() * entry.image.elemSize();
    return sum;
  };
  while (kept_.size() > kKept || (kept_.size() > 1 && bytes() > kKeptBytes)) kept_.pop_front();
}

void VideoDecoder::fail(std::size_t k, const Stream& stream, const std::string& what) {
  std::string reason = name(k) + ": " + what;
  if (!stream.complaint.empty()) reason += " (ffmpeg: " + stream.complaint + ")";
  failed_.emplace(k, std::move(reason));
}

void VideoDecoder::close(const Stream* stream) {
  streams_.remove_if([&](const Stream& s) { return &s == stream; });
}

/// showinfo@all speaks of each decoded frame, showinfo@out of each that passed `select`, both
/// before its pixels are written.
void VideoDecoder::note(Stream& stream, std::string_view line) const {
  const bool all = line.find("showinfo@all") != std::string_view::npos;
  if (!all && line.find("showinfo@out") == std::string_view::npos) {
    for (const char* sign : {"CRC mismatch", "concealing", "error while decoding MB",
                             "Packet corrupt", "corrupt decoded frame"})
      if (line.find(sign) != std::string_view::npos) stream.suspect = kDecodedAhead;
    // "[error] …", where ffmpeg has anything to complain about.
    const std::size_t error = line.find("[error] ");
    if (error != std::string_view::npos) stream.complaint = line.substr(error + 8, 160);
    return;
  }
  const auto pts = number_after(line, " pts:");
  if (!pts) return;
  if (!all) {
    const auto same = [&](const Announced& a) { return a.pts == *pts; };
    const auto decoded = std::find_if(stream.decoded.rbegin(), stream.decoded.rend(), same);
    stream.announced.push_back({*pts, decoded != stream.decoded.rend() && decoded->sound});
    return;
  }
  const auto frame = frame_with(*pts);
  const bool gap = !frame || (stream.previous && *frame != *stream.previous + 1);
  const bool same_size = line.find(" s:" + std::to_string(info_.width_px) + "x" +
                                   std::to_string(info_.height_px) + " ") != std::string_view::npos;
  const bool suspect = stream.suspect > 0;
  if (suspect) --stream.suspect;
  if (gap || suspect || !same_size) stream.sound = false;
  if (frame && same_size && !suspect && number_after(line, " iskey:") == 1) stream.sound = true;
  if (frame) stream.previous = frame;
  if (stream.sound && !stream.begins_at) stream.begins_at = frame;
  stream.decoded.push_back({*pts, stream.sound});
  if (stream.decoded.size() > kRemembered) stream.decoded.pop_front();
}

Result<VideoDecoder::Stream*> VideoDecoder::open(std::size_t k, const Form& form, int attempt) {
  const std::size_t wanted = chosen_[k];
  std::size_t key = wanted;
  while (key > 0 && !info_.frames[key].key) --key;

  std::vector<std::string> arguments = {
      "ffmpeg", "-hide_banner", "-nostdin", "-nostats", "-loglevel", "repeat+level+info",
      // A playlist in disguise must not make it open anything else.
      "-protocol_whitelist", "file", "-noautorotate",
      // A frame that would be patched up is dropped instead.
      "-err_detect:v", "explode"};
  const double tick_s =
      static_cast<double>(info_.tick_numerator) / static_cast<double>(info_.tick_denominator);
  const double key_s =
      static_cast<double>(info_.frames[key].pts) * tick_s - kSeekEarlier_s * attempt;
  const bool seeks =
      key > 0 && attempt < 2 && key_s > static_cast<double>(info_.frames.front().pts) * tick_s;
  if (seeks) {
    // To the whole microsecond above, where ffmpeg's clock finds this key frame and not the one
    // before.
    char seek[40];
    std::snprintf(seek, sizeof seek, "%.6f", std::ceil(key_s * 1e6) * 1e-6);
    arguments.insert(arguments.end(), {"-noaccurate_seek", "-seek_timestamp", "1", "-ss", seek});
  }

  const int n = form.reduction;
  const int cols = blocks(info_.width_px, n), rows = blocks(info_.height_px, n);
  std::string filters = "showinfo@all=checksum=0,select='" +
                        choice_.expression(info_.frames[wanted].pts) + "',showinfo@out=checksum=0";
  if (cols * n != info_.width_px || rows * n != info_.height_px)
    // The last blocks are filled up with the image's edge.
    filters += ",pad=" + std::to_string(cols * n) + ":" + std::to_string(rows * n) +
               ":0:0,fillborders=right=" + std::to_string(cols * n - info_.width_px) +
               ":bottom=" + std::to_string(rows * n - info_.height_px) + ":mode=smear";
  filters += ",scale=" + std::to_string(cols) + ":" + std::to_string(rows) +
             ":flags=" + (n > 1 ? "area" : "bicubic") +
             "+accurate_rnd+full_chroma_int+full_chroma_inp";
  arguments.insert(arguments.end(), {"-copyts", "-i", "file:" + info_.path.string(), "-map",
                                     "0:" + std::to_string(info_.stream), "-vf", filters,
                                     "-fps_mode", "passthrough", "-c:v", "rawvideo", "-pix_fmt",
                                     form.color          ? "bgr24"
                                     : info_.sixteen_bit ? "gray16le"
                                                         : "gray",
                                     "-f", "rawvideo", "pipe:1"});
  WATERSKY_TRY(ChildProcess process, ChildProcess::start(arguments, "ffmpeg"));
  streams_.emplace_front(form, std::move(process), k, seeks);
  if (streams_.size() > kStreams) streams_.pop_back();
  return &streams_.front();
}

Result<VideoDecoder::Stream*> VideoDecoder::stream_at(std::size_t k, const Form& form) {
  for (auto it = streams_.begin(); it != streams_.end(); ++it) {
    if (it->form != form) continue;
    const bool far =
        k > it->next + kSeekBeyond && !it->ended && key_between(chosen_[it->next], chosen_[k]);
    if (k < it->next || far) {
      streams_.erase(it);
      break;
    }
    streams_.splice(streams_.begin(), streams_, it);
    return &streams_.front();
  }
  return open(k, form, 0);
}

/// Reads until the k-th chosen frame has been kept or has failed.
Status VideoDecoder::advance(Stream& stream, std::size_t k) {
  const int n = stream.form.reduction;
  const int type = stream.form.color ? CV_8UC3 : info_.sixteen_bit ? CV_16UC1 : CV_8UC1;
  const LineHandler on_line = [&](std::string_view line) { note(stream, line); };
  while (stream.next <= k) {
    cv::Mat image(blocks(info_.height_px, n), blocks(info_.width_px, n), type);
    const std::size_t size = image.total() * image.elemSize();
    std::size_t read = 0;
    if (!stream.ended) {
      WATERSKY_TRY(read, stream.process.read({image.data, size}, on_line));
      stream.ended = read < size;
    }
    if (stream.ended) {
      for (; stream.next <= k; ++stream.next)
        fail(stream.next, stream, "cannot be decoded: the video is damaged or ends before it");
      return {};
    }
    if (stream.announced.empty())
      return Error{
          ErrorCode::Unsupported,
          info_.path.string() + ": this version of ffmpeg does not say which frame it has decoded"};
    const Announced announced = stream.announced.front();
    stream.announced.pop_front();
    const auto frame = frame_with(announced.pts);
    if (!frame) continue;
    const auto at = std::lower_bound(chosen_.begin(), chosen_.end(), *frame);
    const auto got = static_cast<std::size_t>(at - chosen_.begin());
    for (; stream.next < got && stream.next < chosen_.size(); ++stream.next)
      fail(stream.next, stream, "cannot be decoded: the video is damaged there");
    if (at == chosen_.end() || *at != *frame || got < stream.next) continue;
    if (announced.sound)
      keep(got, stream.form, std::move(image));
    else
      fail(got, stream, "is damaged, or builds on frames that are");
    stream.next = got + 1;
  }
  return {};
}

Result<cv::Mat> VideoDecoder::load(std::size_t k, const ImageRequest& request) {
  const int n = request.reduction;
  if (n != 1 && n != 2 && n != 4 && n != 8)
    return Error{ErrorCode::Usage,
                 "an image can be reduced by 1, 2, 4 or 8, not " + std::to_string(n)};
  const Form form{request.color && !info_.gray, n};
  const std::lock_guard lock(mutex_);
  constexpr int kAttempts = 3;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (const cv::Mat image = kept(k, form); !image.empty()) return image.clone();
    if (const auto failed = failed_.find(k); failed != failed_.end())
      return Error{ErrorCode::InvalidInput, failed->second};
    WATERSKY_TRY(Stream* const stream, attempt == 0 ? stream_at(k, form) : open(k, form, attempt));
    if (const Status done = advance(*stream, k); !done) {
      const Error error = done.error().at(name(k));
      close(stream);
      return error;
    }
    // Where a seek came out behind the frame, nothing is wrong with the video.
    const bool late = stream->sought && (!stream->begins_at || *stream->begins_at > chosen_[k]);
    if (failed_.contains(k) && late) {
      // (The last attempt begins at the start and is never late.)
      failed_.erase(k);
      close(stream);
    }
  }
  if (const cv::Mat image = kept(k, form); !image.empty()) return image.clone();
  const auto failed = failed_.find(k);
  return Error{ErrorCode::InvalidInput,
               failed != failed_.end() ? failed->second : name(k) + ": cannot be decoded"};
}

}  // namespace watersky::detail
