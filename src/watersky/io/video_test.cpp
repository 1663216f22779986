// SPDX-License-Identifier: MIT
#include "watersky/io/video.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <random>
#include <thread>

#include "support/make_photo.hpp"
#include "watersky/io/inspect.hpp"
#include "watersky/io/name_time.hpp"
#include "watersky/io/read_flight.hpp"
#include "watersky/wire/tlog.hpp"

namespace watersky {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using watersky::test::Bytes;
using watersky::test::TemporaryFolder;
using watersky::test::write;

constexpr Time kBoot{std::chrono::seconds(1'533'430'800)};  // 2018-08-05T01:00:00Z
constexpr int kWidth = 66, kHeight = 50;                    // no multiple of 4
constexpr int kRate_hz = 30;

/// Blocks that say which frame this is, over a gradient that says which way is up.
cv::Mat picture(int n) {
  cv::Mat image(kHeight, kWidth, CV_8UC3);
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u)
      image.at<cv::Vec3b>(v, u) = cv::Vec3b(static_cast<uchar>(3 * u), static_cast<uchar>(5 * v),
                                            static_cast<uchar>(n % 256));
  for (int bit = 0; bit < 8; ++bit)
    image(cv::Rect(2 + 8 * bit, 10, 6, 6))
        .setTo((n >> bit) & 1 ? cv::Scalar(255, 255, 255) : cv::Scalar(0, 0, 0));
  return image;
}

bool have_ffmpeg() {
  static const bool here =
      std::system("ffmpeg -version >/dev/null 2>&1 && ffprobe -version >/dev/null 2>&1") == 0;
  return here;
}

/// Encodes pictures 0 to `frames`, not through the code under test.
void make_video(const fs::path& file, int frames, const std::string& codec,
                const std::string& more = "", bool gray16 = false) {
  const std::string command = "ffmpeg -v error -y -f rawvideo -pix_fmt " +
                              std::string(gray16 ? "gray16le" : "bgr24") + " -s " +
                              std::to_string(kWidth) + "x" + std::to_string(kHeight) + " -r " +
                              std::to_string(kRate_hz) + " -i pipe:0 -c:v " + codec + " " + more +
                              " '" + file.string() + "'";
  std::FILE* pipe = ::popen(command.c_str(), "w");
  ASSERT_NE(pipe, nullptr);
  for (int n = 0; n < frames; ++n) {
    cv::Mat image = picture(n);
    if (gray16) {
      cv::cvtColor(image, image, cv::COLOR_BGR2GRAY);
      image.convertTo(image, CV_16U, 3, 7000);
    }
    std::fwrite(image.data, 1, image.total() * image.elemSize(), pipe);
  }
  ASSERT_EQ(::pclose(pipe), 0) << command;
}
const std::string kLossless = "libx264rgb";
const std::string kLosslessOptions = "-qp 0 -g 12 -bf 0";

/// Straight and level, north at 10 m/s, 80 m above home.
Bytes straight_log(double length_s) {
  Bytes log;
  const auto send = [&](const mavlink::Message& m, double t) {
    mavlink::append_tlog_record(log, kBoot + seconds(t), mavlink::encode(m, {1, 1, 0}).value());
  };
  for (double t = 0; t < length_s; t += 0.1) {
    mavlink::Message a(*mavlink::find_message("ATTITUDE"));
    a.set("time_boot_ms", t * 1e3).set("yaw", Angle::degrees(30).radians());
    send(a, t);
    mavlink::Message p(*mavlink::find_message("GLOBAL_POSITION_INT"));
    p.set("time_boot_ms", t * 1e3)
        .set("lat", (78.9 + 10.0 * t / 111'660.0) * 1e7)
        .set("lon", 11.9e7);
    p.set("alt", 95e3).set("relative_alt", 80e3);
    send(p, t);
  }
  return log;
}

double difference(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) return 1e9;
  return cv::norm(a, b, cv::NORM_INF);
}

class Video : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!have_ffmpeg()) GTEST_SKIP() << "ffmpeg is not installed";
  }
  void TearDown() override {
    // Nothing that was started is left, neither running nor as a zombie.
    EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);
    EXPECT_EQ(errno, ECHILD);
  }
  TemporaryFolder folder;
};

TEST_F(Video, EveryFrameIsItselfWhateverTheOrderAndTheCodec) {
  struct Case {
    const char* name;
    std::string codec, options;
  };
  for (const Case& c :
       {Case{"a.mp4", kLossless, kLosslessOptions}, Case{"b.mp4", kLossless, "-qp 0 -g 15 -bf 3"},
        Case{"c.mkv", "ffv1", "-pix_fmt bgr0"}, Case{"d.ts", kLossless, "-qp 0 -g 10 -bf 2"},
        Case{"e.avi", "ffv1", "-pix_fmt bgr0"}, Case{"f.mov", kLossless, "-qp 0 -g 250"}}) {
    const fs::path file = folder.path() / c.name;
    make_video(file, 100, c.codec, c.options);
    const auto info = probe_video(file);
    ASSERT_TRUE(info) << info.error().message;
    ASSERT_EQ(info->frames.size(), 100u) << c.name;
    EXPECT_EQ(info->width_px, kWidth);
    EXPECT_EQ(info->height_px, kHeight);
    EXPECT_NEAR(info->rate_hz(), 30, 0.02);
    const auto frames = video_frames(*info, 0, kBoot);
    ASSERT_THAT(frames, SizeIs(100));
    EXPECT_EQ(frames[7].name, std::string(c.name) + "#7");
    EXPECT_EQ(frames[7].counter, 7u);
    for (std::size_t n = 0; n < frames.size(); ++n)
      EXPECT_NEAR(to_seconds(*frames[n].captured_at - kBoot), static_cast<double>(n) / kRate_hz,
                  0.6e-3)
          << c.name << " " << n;
    std::mt19937 rng(3);
    std::vector<int> order;
    for (int n = 0; n < 100; n += 3) order.push_back(n);
    for (int i = 0; i < 12; ++i) order.push_back(std::uniform_int_distribution(0, 99)(rng));
    for (const int n : order) {
      const auto image = frames[static_cast<std::size_t>(n)].load({});
      ASSERT_TRUE(image) << image.error().message;
      EXPECT_EQ(difference(*image, picture(n)), 0) << c.name << " frame " << n;
    }
  }
}

TEST_F(Video, FramesAreChosenByTimeAndDecodeToThemselves) {
  for (const auto& [name, codec, options] :
       {std::tuple("a.mp4", kLossless, kLosslessOptions),
        std::tuple("a.mkv", std::string("ffv1"), std::string("-pix_fmt bgr0"))}) {
    make_video(folder.path() / name, 100, codec, options);
    const VideoInfo info = probe_video(folder.path() / name).value();
    EXPECT_THAT(choose_video_frames(info, 0.5), ElementsAre(0, 15, 30, 45, 60, 75, 90)) << name;
    EXPECT_THAT(choose_video_frames(info, 0.0), SizeIs(100));
    EXPECT_THAT(choose_video_frames(info, 1e-9), SizeIs(100));
    EXPECT_THAT(choose_video_frames(info, 1e9), ElementsAre(0));
    for (const double interval : {0.5, 0.1, 0.07, 0.9}) {
      const auto frames = video_frames(info, interval, kBoot);
      for (std::size_t k = 0; k < frames.size(); ++k) {
        if (k > 0) {
          EXPECT_GT(*frames[k].captured_at,
                    *frames[k - 1].captured_at + seconds(interval - 1.001 / kRate_hz));
        }
        EXPECT_EQ(
            difference(frames[k].load({}).value(), picture(static_cast<int>(*frames[k].counter))),
            0)
            << interval << " " << k;
      }
    }
  }
}

TEST_F(Video, AReducedFrameIsTheMeanOfWholeBlocks) {
  make_video(folder.path() / "a.mp4", 20, kLossless, kLosslessOptions);
  const auto frames = video_frames(probe_video(folder.path() / "a.mp4").value(), 0, kBoot);
  const cv::Mat full = picture(5);
  for (const int n : {1, 2, 4, 8})
    for (const bool color : {true, false}) {
      cv::Mat wanted;
      const int cols = (kWidth + n - 1) / n, rows = (kHeight + n - 1) / n;
      cv::copyMakeBorder(full, wanted, 0, rows * n - kHeight, 0, cols * n - kWidth,
                         cv::BORDER_REPLICATE);
      if (!color) cv::cvtColor(wanted, wanted, cv::COLOR_BGR2GRAY);
      cv::resize(wanted, wanted, {cols, rows}, 0, 0, cv::INTER_AREA);
      const cv::Mat image = frames[5].load({.color = color, .reduction = n}).value();
      ASSERT_EQ(image.size(), wanted.size());
      ASSERT_EQ(image.type(), wanted.type());
      // ffmpeg's scaler goes by Y'CbCr.
      EXPECT_LE(difference(image, wanted), n == 1 && color ? 0 : 5) << n << " " << color;
      EXPECT_LE(cv::norm(image, wanted, cv::NORM_L1) /
                    static_cast<double>(wanted.total() * wanted.channels()),
                1.5)
          << n << " " << color;
    }
  EXPECT_EQ(frames[5].load({.color = true, .reduction = 3}).error().code, ErrorCode::Usage);
}

TEST_F(Video, SixteenBitGrayKeepsItsBits) {
  make_video(folder.path() / "thermal.mkv", 5, "ffv1", "-level 3 -pix_fmt gray16le", true);
  const auto frames = video_frames(probe_video(folder.path() / "thermal.mkv").value(), 0, kBoot);
  cv::Mat wanted = picture(3);
  cv::cvtColor(wanted, wanted, cv::COLOR_BGR2GRAY);
  wanted.convertTo(wanted, CV_16U, 3, 7000);
  EXPECT_EQ(difference(frames[3].load({.color = true}).value(), wanted), 0);
}

TEST_F(Video, ManyThreadsGetTheirOwnFrames) {
  make_video(folder.path() / "a.mp4", 90, kLossless, kLosslessOptions);
  const auto frames = video_frames(probe_video(folder.path() / "a.mp4").value(), 0.1, kBoot);
  std::atomic<std::size_t> next{0};
  std::atomic<int> wrong{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      for (std::size_t k = next++; k < frames.size(); k = next++) {
        const auto image = frames[k].load({.color = k % 5 != 0});
        cv::Mat wanted = picture(static_cast<int>(*frames[k].counter));
        if (k % 5 == 0) cv::cvtColor(wanted, wanted, cv::COLOR_BGR2GRAY);
        if (!image || difference(*image, wanted) > (k % 5 == 0 ? 3 : 0)) ++wrong;
      }
    });
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(wrong, 0);
}

// A codec patches up what is missing: such pixels must not reach the map.
TEST_F(Video, ADamagedFrameIsAnErrorAndNeverAnotherPicture) {
  make_video(folder.path() / "whole.ts", 100, kLossless, kLosslessOptions);
  make_video(folder.path() / "whole.mp4", 100, kLossless,
             kLosslessOptions + " -movflags +faststart");
  make_video(folder.path() / "whole.mkv", 100, "ffv1", "-level 3 -slicecrc 1 -pix_fmt bgr0");
  std::mt19937 rng(11);
  std::size_t good = 0, refused = 0;
  for (const char* name : {"whole.ts", "whole.mp4", "whole.mkv"}) {
    std::ifstream in(folder.path() / name, std::ios::binary);
    const Bytes whole((std::istreambuf_iterator<char>(in)), {});
    for (int trial = 0; trial < 4; ++trial) {
      Bytes bytes = whole;
      if (trial < 2) {
        bytes.resize(whole.size() * (trial == 0 ? 6 : 9) / 10);
      } else {
        // Lost packets of a stream, blank blocks of a card, bits that only a checksum can tell.
        const std::string kind = fs::path(name).extension();
        const std::size_t at = std::uniform_int_distribution<std::size_t>(
                                   whole.size() / 3, whole.size() * 2 / 3)(rng) /
                               188 * 188;
        const auto from = bytes.begin() + static_cast<std::ptrdiff_t>(at);
        if (kind == ".ts") bytes.erase(from, from + 188 * 5);
        if (kind == ".mp4") std::fill(from, from + 2048, std::uint8_t{0});
        if (kind == ".mkv")
          std::generate(from, from + 40, [&] { return static_cast<std::uint8_t>(rng()); });
      }
      const fs::path file = folder.path() / ("damaged" + fs::path(name).extension().string());
      write(file, bytes);
      const auto info = probe_video(file);
      if (!info) continue;
      for (const ImageFrame& frame : video_frames(*info, 0.1, kBoot)) {
        const auto image = frame.load({});
        if (!image) {
          EXPECT_THAT(image.error().message, HasSubstr("damaged"));
          ++refused;
          continue;
        }
        // By its time, as numbers shift where the container has lost a frame.
        const int n =
            static_cast<int>(std::lround(to_seconds(*frame.captured_at - kBoot) * kRate_hz));
        EXPECT_EQ(difference(*image, picture(n)), 0)
            << name << " trial " << trial << " " << frame.name;
        ++good;
      }
    }
  }
  EXPECT_GT(good, 200u);
  EXPECT_GT(refused, 2u);
}

TEST_F(Video, WhatIsNoVideoIsSaidToBeNone) {
  EXPECT_EQ(probe_video(folder.path() / "none.mp4").error().code, ErrorCode::NotFound);
  EXPECT_EQ(probe_video(folder.path()).error().code, ErrorCode::InvalidInput);
  write(folder.path() / "text.mp4", std::string("this is no video"));
  write(folder.path() / "empty.mkv", std::string());
  write(folder.path() / "list.ts", std::string("#EXTM3U\n#EXTINF:10,\nhttp://127.0.0.1:9/a.ts\n"));
  for (const char* name : {"text.mp4", "empty.mkv", "list.ts"}) {
    const auto info = probe_video(folder.path() / name);
    ASSERT_FALSE(info) << name;
    EXPECT_EQ(info.error().code, ErrorCode::InvalidInput) << name;
    EXPECT_THAT(info.error().message, HasSubstr(name));
    EXPECT_EQ(info.error().message.find('\n'), std::string::npos);
  }
  // An index at the end that was never written: the camera lost power.
  make_video(folder.path() / "a.mp4", 50, kLossless, kLosslessOptions);
  fs::resize_file(folder.path() / "a.mp4", fs::file_size(folder.path() / "a.mp4") / 2);
  EXPECT_EQ(probe_video(folder.path() / "a.mp4").error().code, ErrorCode::InvalidInput);
}

TEST_F(Video, ANameIsNeverACommand) {
  const fs::path file = folder.path() / "-i;touch hurt $(touch hurt) 'a' [1],b=c#.mp4";
  make_video(folder.path() / "a.mp4", 3, kLossless, kLosslessOptions);
  fs::rename(folder.path() / "a.mp4", file);
  const auto frames = video_frames(probe_video(file).value(), 0, kBoot);
  EXPECT_EQ(difference(frames[2].load({}).value(), picture(2)), 0);
  EXPECT_FALSE(fs::exists("hurt"));
}

TEST_F(Video, WithoutFfmpegItSaysWhichPackageToInstall) {
  write(folder.path() / "a.mp4", std::string("x"));
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", folder.path().c_str(), 1);
  const auto info = probe_video(folder.path() / "a.mp4");
  ::setenv("PATH", path.c_str(), 1);
  ASSERT_FALSE(info);
  EXPECT_THAT(info.error().message, HasSubstr("install the package ffmpeg"));
}

TEST_F(Video, DroppingItInTheMiddleLeavesNothingBehind) {
  make_video(folder.path() / "a.mp4", 100, kLossless, kLosslessOptions);
  auto frames = video_frames(probe_video(folder.path() / "a.mp4").value(), 0, kBoot);
  EXPECT_TRUE(frames[3].load({}));
  EXPECT_TRUE(frames[3].load({.color = false}));
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), 0) << "two decoders should be waiting";
  frames.clear();
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);
}

struct VideoFlight : Video {
  void SetUp() override {
    Video::SetUp();
    if (IsSkipped()) return;
    make_video(folder.path() / "film.mp4", 120, kLossless,
               kLosslessOptions + " -metadata creation_time=2018-08-05T01:00:10Z");
    write(folder.path() / "flight.tlog", straight_log(30));
    options.focal_px = 60;
    options.sea_level = SeaLevelOption{SeaReference::TakeOff, 0};
  }
  ReadOptions options;
};

TEST_F(VideoFlight, PlacesFramesByTheGivenStart) {
  options.video_start = kBoot + seconds(12.25);
  for (const fs::path& path : {folder.path() / "film.mp4", folder.path()}) {
    const auto flight = read_flight(path, options);
    ASSERT_TRUE(flight) << flight.error().message;
    ASSERT_THAT(flight->frames, SizeIs(8));
    EXPECT_TRUE(flight->mount.assumed);
    EXPECT_EQ(flight->camera.width_px(), kWidth);
    EXPECT_EQ(flight->name, "film.mp4");
    for (const ImageFrame& frame : flight->frames) {
      const double t = 12.25 + static_cast<double>(*frame.counter) / kRate_hz;
      const auto pose = flight->camera_pose(frame, std::chrono::milliseconds(500));
      ASSERT_TRUE(pose) << pose.error().message;
      EXPECT_NEAR(pose->world_from_camera.origin().v.x(), 10.0 * t, 0.1);
      EXPECT_NEAR(-pose->sea_from_camera.origin().v.z(), 80.0, 1e-2);
      EXPECT_EQ(difference(frame.load({}).value(), picture(static_cast<int>(*frame.counter))), 0);
    }
  }
}

TEST_F(VideoFlight, TheStartComesFromTheBestSourceAndItIsSaid) {
  const auto start = [&](const fs::path& file) {
    const Flight flight = read_flight(file, options).value();
    return std::pair(to_iso8601(*flight.frames.front().captured_at), flight.notes);
  };
  auto [iso, notes] = start(folder.path() / "film.mp4");
  EXPECT_EQ(iso, "2018-08-05T01:00:10.000Z");
  EXPECT_THAT(notes, Contains(HasSubstr("good to a second at best")));
  fs::copy_file(folder.path() / "film.mp4", folder.path() / "20180805T010011.5Z.mp4");
  fs::copy_file(folder.path() / "film.mp4", folder.path() / "cam_20180805_010012.mp4");
  EXPECT_EQ(start(folder.path() / "20180805T010011.5Z.mp4").first, "2018-08-05T01:00:11.500Z");
  options.name_pattern = "YYYYMMDD?hhmmss";
  EXPECT_EQ(start(folder.path() / "cam_20180805_010012.mp4").first, "2018-08-05T01:00:12.000Z");
  EXPECT_EQ(read_flight(folder.path() / "film.mp4", options).error().code, ErrorCode::Usage);
  EXPECT_THAT(read_flight(folder.path(), options).error().message, HasSubstr("holds 3 videos"));
}

TEST_F(VideoFlight, WithoutAStartALensOrALogItStopsAndExplains) {
  make_video(folder.path() / "mute.mkv", 30, "ffv1", "-pix_fmt bgr0");
  EXPECT_THAT(read_flight(folder.path() / "mute.mkv", options).error().message,
              HasSubstr("--video-start"));
  options.focal_px.reset();
  EXPECT_THAT(read_flight(folder.path() / "film.mp4", options).error().message,
              HasSubstr("--focal-px"));
  options.focal_px = 60;
  options.video_frame_interval_s = -1;
  EXPECT_EQ(read_flight(folder.path() / "film.mp4", options).error().code, ErrorCode::Usage);
  options.video_frame_interval_s = 0.5;
  write(folder.path() / "other.tlog", std::string("x"));
  EXPECT_THAT(read_flight(folder.path() / "film.mp4", options).error().message, HasSubstr("--log"));
  fs::rename(folder.path() / "flight.tlog", folder.path() / "film.tlog");
  EXPECT_TRUE(read_flight(folder.path() / "film.mp4", options)) << "the log of its own name";
  fs::remove(folder.path() / "film.tlog");
  fs::remove(folder.path() / "other.tlog");
  EXPECT_THAT(read_flight(folder.path() / "film.mp4", options).error().message, HasSubstr("--log"));
}

TEST_F(VideoFlight, PhotographsComeBeforeAVideoBesideThem) {
  write(folder.path() / "20180805T010005Z.jpg", watersky::test::make_photo({}));
  EXPECT_EQ(recording_kind(folder.path()).value(), RecordingKind::PhotographsWithLog);
  fs::remove(folder.path() / "20180805T010005Z.jpg");
  EXPECT_EQ(recording_kind(folder.path()).value(), RecordingKind::VideoWithLog);
}

TEST_F(VideoFlight, ADelayMakesTimesArrivals) {
  options.delay_s = 0.5;
  const Flight flight = read_flight(folder.path(), options).value();
  EXPECT_FALSE(flight.frames[0].captured_at);
  EXPECT_EQ(flight.capture_time(flight.frames[0]).value(), kBoot + std::chrono::milliseconds(9500));
}

TEST_F(VideoFlight, InspectTellsWhatIsInIt) {
  const Inspection video = inspect(folder.path() / "film.mp4").value();
  EXPECT_EQ(video.kind, "video");
  EXPECT_EQ(video.counts.at("frames"), 120u);
  EXPECT_NEAR(video.rates_hz.at("frames"), 30, 1e-6);
  EXPECT_EQ(video.facts.at("size"), "66x50");
  EXPECT_EQ(to_iso8601(*video.first), "2018-08-05T01:00:10.000Z");
  const auto flight = inspect(folder.path());
  ASSERT_TRUE(flight) << flight.error().message;
  EXPECT_EQ(flight->kind, "video_with_log");
  EXPECT_EQ(flight->counts.at("frames"), 8u);
}

TEST(VideoStart, SaysItsZone) {
  const auto text = [](const char* given) {
    const auto t = parse_video_start_option(given);
    return t ? to_iso8601(*t) : std::string(to_string(t.error().code));
  };
  EXPECT_EQ(text("2018-08-05T01:00:44.80Z"), "2018-08-05T01:00:44.800Z");
  EXPECT_EQ(text("2018-08-05 03:00:44+02:00"), "2018-08-05T01:00:44.000Z");
  EXPECT_EQ(text("1533430844.48"), "2018-08-05T01:00:44.480Z");
  const std::string usage(to_string(ErrorCode::Usage));
  for (const char* bad : {"", "2018-08-05T01:00:44", "2018-08-05", "2018-13-05T01:00:44Z",
                          "2018-08-05T01:00:44.Z", "2018-08-05T01:00:44Zz", "noon"})
    EXPECT_EQ(text(bad), usage) << bad;
}

}  // namespace
}  // namespace watersky
