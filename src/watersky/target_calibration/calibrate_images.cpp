// SPDX-License-Identifier: MIT
#include "watersky/target_calibration/calibrate_images.hpp"

#include <algorithm>
#include <atomic>
#include <map>
#include <opencv2/core.hpp>
#include <thread>

namespace watersky {

namespace {

struct Seen {
  cv::Size size;
  std::optional<DetectedTarget> target;
  std::string reason;
};

/// `text` without the place in front that its reader knows.
std::string without_place(const std::string& text, const std::string& place) {
  return text.starts_with(place + ": ") ? text.substr(place.size() + 2) : text;
}

Seen look_at(const CalibrationImage& image, const TargetRequest& request) {
  Seen seen;
  const auto pixels = image.load();
  if (!pixels) {
    seen.reason = without_place(pixels.error().message, image.name);
    return seen;
  }
  seen.size = pixels->size();
  auto target = detect_target(*pixels, request);
  if (target)
    seen.target = *std::move(target);
  else
    seen.reason = target.error().message;
  return seen;
}

/// The value that most have; of those, the largest. Needs one at least.
template <class Value, class Less = std::less<Value>>
Value most_frequent(const std::vector<Value>& values, Less less = {}) {
  std::map<Value, int, Less> counts(less);
  for (const Value& v : values) ++counts[v];
  auto best = counts.begin();
  for (auto it = counts.begin(); it != counts.end(); ++it)
    if (it->second >= best->second) best = it;
  return best->first;
}

bool smaller(const TargetSize& a, const TargetSize& b) {
  return a.points() != b.points() ? a.points() < b.points() : a.columns < b.columns;
}

/// 9x6 and 6x9 are one target, lying and upright. Not so where rows and columns are counted apart.
TargetSize lying(TargetKind kind, const TargetSize& size) {
  if (kind == TargetKind::AsymmetricCircles || size.columns >= size.rows) return size;
  return {size.rows, size.columns};
}

}  // namespace

Result<TargetCalibration> calibrate_images(const std::vector<CalibrationImage>& images,
                                           const ImageCalibrationOptions& options,
                                           const Progress& progress) {
  if (images.empty())
    return Error{ErrorCode::NotFound, "there are no images; give some, or the folder they are in"};
  std::vector<Seen> seen(images.size());
  const auto look = [&](const std::vector<std::size_t>& which, const TargetRequest& request) {
    std::atomic<std::size_t> next{0};
    const auto work = [&](bool tells) {
      for (std::size_t i; (i = next++) < which.size();) {
        if (tells) report(progress, "detecting", i, which.size());
        seen[which[i]] = look_at(images[which[i]], request);
      }
    };
    {
      std::vector<std::jthread> others;
      for (int t = 1; t < std::min(options.threads, static_cast<int>(which.size())); ++t)
        others.emplace_back([&] { work(false); });
      work(true);
    }
    report(progress, "detecting", which.size(), which.size());
  };
  std::vector<std::size_t> all(images.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  look(all, options.target);

  std::vector<std::pair<int, int>> image_sizes;
  std::vector<TargetKind> kinds;
  for (const Seen& s : seen) {
    if (s.size.area() > 0) image_sizes.emplace_back(s.size.width, s.size.height);
    if (s.target) kinds.push_back(s.target->kind);
  }
  if (image_sizes.empty())
    return Error{ErrorCode::InvalidInput, images.front().name + ": " + seen.front().reason};
  if (kinds.empty()) {
    std::string hint = "; is the whole target in the pictures, flat and sharp?";
    if (options.target.size) {
      // A wrong size is the commonest fault; what is there tells the right one.
      TargetRequest any = options.target;
      any.size.reset();
      for (std::size_t i = 0; i < std::min<std::size_t>(4, images.size()); ++i)
        if (const Seen other = look_at(images[i], any); other.target) {
          hint = "; " + images[i].name + " shows " + std::string(name_of(other.target->kind)) +
                 " of " + to_string(other.target->size) +
                 ": is that the right --size? A chessboard's are its inner corners";
          break;
        }
    }
    return Error{ErrorCode::NotFound,
                 (images.size() == 1 ? images[0].name + ": "
                                     : "none of " + std::to_string(images.size()) +
                                           " images shows the target: " + images[0].name + ": ") +
                     seen[0].reason + hint};
  }
  TargetRequest request{most_frequent(kinds), options.target.size};
  const bool size_was_found = !request.size;
  if (size_was_found) {
    std::vector<TargetSize> sizes;
    for (const Seen& s : seen)
      if (s.target && s.target->kind == *request.kind)
        sizes.push_back(lying(*request.kind, s.target->size));
    request.size = most_frequent(sizes, smaller);
  }
  // Parts of a grid of circles may stay; what is larger, or of another kind, is looked at again.
  std::vector<std::size_t> again;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (!seen[i].target) continue;
    const TargetSize size = lying(*request.kind, seen[i].target->size);
    const TargetSize whole = lying(*request.kind, *request.size);
    const bool fits =
        *request.kind == TargetKind::Chessboard
            ? size == whole
            : size.columns <= whole.columns && size.rows <= whole.rows &&
                  2 * static_cast<int>(seen[i].target->points.size()) >= whole.points();
    if (seen[i].target->kind != *request.kind || !fits) again.push_back(i);
  }
  if (!again.empty()) look(again, request);

  const auto [width, height] = most_frequent(image_sizes);
  std::vector<CalibrationView> views;
  for (std::size_t i = 0; i < images.size(); ++i) {
    CalibrationView view;
    view.name = images[i].name;
    view.reason = seen[i].reason;
    view.target = std::move(seen[i].target);
    if (seen[i].size.area() > 0 && seen[i].size != cv::Size(width, height)) {
      view.reason = "is of " + std::to_string(seen[i].size.width) + "x" +
                    std::to_string(seen[i].size.height) + " pixels, most images are of " +
                    std::to_string(width) + "x" + std::to_string(height);
      view.target.reset();
    }
    views.push_back(std::move(view));
  }
  WATERSKY_TRY(
      TargetCalibration result,
      calibrate_views(std::move(views), width, height, options.lens, options.parameters, progress));
  result.kind = *request.kind;
  result.size = *request.size;
  result.size_was_found = size_was_found;
  return result;
}

}  // namespace watersky
