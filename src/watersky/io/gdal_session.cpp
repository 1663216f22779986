// SPDX-License-Identifier: MIT
#include "watersky/io/gdal_session.hpp"

#include <cpl_error.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <gdal_priv.h>
#include <unistd.h>

#include <atomic>
#include <mutex>

namespace watersky {

struct GdalHandler {
  static void CPL_STDCALL keep(CPLErr severity, CPLErrorNum, const char* message) {
    auto* session = static_cast<GdalSession*>(CPLGetErrorHandlerUserData());
    if (severity >= CE_Failure && session->failure_.empty()) session->failure_ = message;
  }
};

GdalSession::GdalSession() {
  static std::once_flag registered;
  std::call_once(registered, [] { GDALAllRegister(); });
  CPLPushErrorHandlerEx(&GdalHandler::keep, this);
}

GdalSession::~GdalSession() { CPLPopErrorHandler(); }

Error GdalSession::error(const std::filesystem::path& file) const {
  return {ErrorCode::Io, file.string() + ": cannot be made: " +
                             (failure_.empty() ? std::string("GDAL gave no reason") : failure_)};
}

bool has_gdal_driver(const std::string& name, std::string_view able) {
  const GdalSession registered;
  GDALDriver* const driver = GetGDALDriverManager()->GetDriverByName(name.c_str());
  if (!driver || able.empty()) return driver != nullptr;
  const char* options = driver->GetMetadataItem(GDAL_DMD_CREATIONOPTIONLIST);
  return options && std::string_view(options).find(able) != std::string_view::npos;
}

void DatasetCloser::operator()(GDALDataset* dataset) const { GDALClose(dataset); }

MemoryFile::MemoryFile(const std::string& extension) {
  static std::atomic<unsigned> count{0};
  name_ =
      "/vsimem/watersky-" + std::to_string(::getpid()) + "-" + std::to_string(count++) + extension;
}

MemoryFile::~MemoryFile() { VSIUnlink(name_.c_str()); }

std::string_view MemoryFile::bytes() const {
  vsi_l_offset size = 0;
  const GByte* data = VSIGetMemFileBuffer(name_.c_str(), &size, FALSE);
  if (!data) return {};
  return {reinterpret_cast<const char*>(data), static_cast<std::size_t>(size)};
}

std::string utf8(const std::string& text) {
  if (CPLIsUTF8(text.c_str(), static_cast<int>(text.size()))) return text;
  char* ascii = CPLForceToASCII(text.c_str(), static_cast<int>(text.size()), '?');
  std::string result(ascii);
  CPLFree(ascii);
  return result;
}

}  // namespace watersky
