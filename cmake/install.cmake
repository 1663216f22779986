# SPDX-License-Identifier: MIT
# cmake --install build/release --prefix … ; then find_package(watersky) and link
# watersky::watersky, or single modules such as watersky::map. tests/install does it.
include(CMakePackageConfigHelpers)

get_property(modules GLOBAL PROPERTY WATERSKY_MODULES)
install(TARGETS ${modules} watersky EXPORT watersky
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
if(TARGET watersky_cli)
  install(TARGETS watersky_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
foreach(target ${modules})
  string(REPLACE watersky_ "" module ${target})
  if(IS_DIRECTORY ${PROJECT_SOURCE_DIR}/src/watersky/${module})
    install(DIRECTORY src/watersky/${module} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/watersky
            FILES_MATCHING PATTERN "*.hpp" PATTERN detail EXCLUDE PATTERN testing EXCLUDE)
  endif()
endforeach()
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/watersky)
install(EXPORT watersky NAMESPACE watersky:: FILE watersky-targets.cmake
        DESTINATION ${package_dir})
string(REPLACE ";" " " watersky_opencv "${WATERSKY_OPENCV_COMPONENTS}")
configure_package_config_file(cmake/watersky-config.cmake.in
  ${PROJECT_BINARY_DIR}/watersky-config.cmake INSTALL_DESTINATION ${package_dir})
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/watersky-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/watersky-config.cmake
              ${PROJECT_BINARY_DIR}/watersky-config-version.cmake
        DESTINATION ${package_dir})
