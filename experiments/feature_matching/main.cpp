// SPDX-License-Identifier: MIT
#include <cstdarg>
#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <string_view>
#include "study.hpp"
#include "support/real_data.hpp"
namespace watersky::study {
namespace { std::string g_table; }
void tell(const char* format, ...) {
  char text[400];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  g_table += text;
  std::fputs(text, stderr);
}
const std::string& told() { return g_table; }
std::vector<Contender> contenders() {
  std::vector<Contender> out;
  for (auto m : registration_methods()) {
    if (getenv("ONLY") && !strstr(getenv("ONLY"), std::string(name_of(m)).c_str())) continue;
    auto r = make_registrar(m);
    if (!r) { tell("%s\n", r.error().message.c_str()); continue; }
    out.push_back({m, std::string(name_of(m)), std::move(r).value()});
  }
  return out;
}
}
using namespace watersky; using namespace watersky::study;
int main(int argc, char** argv) {
  cv::setNumThreads(1);
  std::filesystem::path d = argv[1];
  auto s = study_warps({d / "hotrax_pack_ice/images", d / "brighton_beach/images"}, atoi(argv[2]), atoi(argv[3]));
  if (!s) std::fprintf(stderr, "%s\n", s.error().message.c_str());
}
