# SPDX-License-Identifier: MIT
include(CMakePackageConfigHelpers)
get_property(modules GLOBAL PROPERTY WATERSKY_MODULES)
install(TARGETS ${modules} watersky EXPORT watersky
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS watersky_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY src/watersky DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
        FILES_MATCHING PATTERN "*.hpp" PATTERN "detail" EXCLUDE)
install(EXPORT watersky NAMESPACE watersky:: FILE watersky-targets.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/watersky)
configure_package_config_file(cmake/watersky-config.cmake.in
  ${PROJECT_BINARY_DIR}/watersky-config.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/watersky)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/watersky-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/watersky-config.cmake
              ${PROJECT_BINARY_DIR}/watersky-config-version.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/watersky)
