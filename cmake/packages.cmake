# SPDX-License-Identifier: MIT
# The packages of other people that the modules stand on. Each module names those it uses.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
set(WATERSKY_OPENCV_COMPONENTS core imgproc imgcodecs calib3d features2d video)
find_package(OpenCV 4.5 REQUIRED COMPONENTS ${WATERSKY_OPENCV_COMPONENTS})
find_package(GDAL 3.6 REQUIRED)
# PROJ's own version file refuses every cross build, also one for its processor.
set(crosscompiling ${CMAKE_CROSSCOMPILING})
set(CMAKE_CROSSCOMPILING FALSE)
find_package(PROJ 9 REQUIRED CONFIG)
set(CMAKE_CROSSCOMPILING ${crosscompiling})
find_package(yaml-cpp 0.7 REQUIRED)
find_package(Boost 1.74 REQUIRED)  # headers
find_package(nlohmann_json 3.11 REQUIRED)
find_package(ZLIB REQUIRED)
find_package(BZip2 REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(turbojpeg REQUIRED IMPORTED_TARGET libturbojpeg)
pkg_check_modules(geographiclib REQUIRED IMPORTED_TARGET geographiclib)
pkg_check_modules(libexif REQUIRED IMPORTED_TARGET libexif)
pkg_check_modules(libzstd REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(libxxhash REQUIRED IMPORTED_TARGET libxxhash)
pkg_check_modules(liblz4 REQUIRED IMPORTED_TARGET liblz4)
find_package(CLI11 2 REQUIRED)
find_package(Ceres 2.1 REQUIRED)

# OpenCV's headers as system headers, so that our warnings stay ours.
foreach(component ${WATERSKY_OPENCV_COMPONENTS})
  get_target_property(dirs opencv_${component} INTERFACE_INCLUDE_DIRECTORIES)
  if(dirs)
    set_property(TARGET opencv_${component} APPEND PROPERTY
                 INTERFACE_SYSTEM_INCLUDE_DIRECTORIES ${dirs})
  endif()
endforeach()
