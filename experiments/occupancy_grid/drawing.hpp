// SPDX-License-Identifier: MIT
#pragma once
/// What the study's pictures share.
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

#include "study.hpp"

namespace watersky::study {

inline const cv::Scalar kPaper(255, 255, 255), kInk(40, 40, 40), kFaint(205, 205, 205);
inline const cv::Scalar kTruth(0, 94, 213), kPath(170, 110, 0), kOurs(150, 115, 0);

enum class Align { Left, Centre, Right };
/// `at` is on the baseline.
void write_text(cv::Mat& picture, const std::string& text, cv::Point at, double scale,
                const cv::Scalar& colour = kInk, Align align = Align::Left);
/// The same with a white edge, to be legible on any ground.
void write_on_map(cv::Mat& picture, const std::string& text, cv::Point at, double scale,
                  const cv::Scalar& colour, Align align = Align::Left, int thickness = 1);

/// Water dark blue, ice white, what nobody saw light gray.
[[nodiscard]] cv::Mat shaded(const cv::Mat& probability);

/// The true outlines and the numbers of Table 4.1 over a view of the room.
void draw_truth(cv::Mat& picture, const sim::Simulation& recording, const RoomView& view);
/// Metre lines at the border, with their values.
void draw_scale(cv::Mat& picture, const RoomView& view);

Status write_picture(const std::filesystem::path& file, const cv::Mat& picture);

}  // namespace watersky::study
