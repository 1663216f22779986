# SPDX-License-Identifier: MIT
# watersky_module(NAME SOURCES … LINKS … PRIVATE_LINKS … TESTS … TEST_LINKS …)
#
# One static library watersky_NAME, alias watersky::NAME, headers beside their sources.
# LINKS are public: other modules, and packages that our headers show. The include
# directory of a module shows all headers, so tests/layering checks what LINKS promise.

add_library(watersky_warnings INTERFACE)
target_compile_options(watersky_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor
  -Wold-style-cast -Woverloaded-virtual
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>  # g++ 12 sees overlaps in std::string (PR105651)
  -Werror=return-type
  -Werror=unused-result)

add_library(watersky_options INTERFACE)
if(WATERSKY_SANITIZE)
  target_compile_options(watersky_options INTERFACE
    -fsanitize=${WATERSKY_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=undefined)
  target_link_options(watersky_options INTERFACE -fsanitize=${WATERSKY_SANITIZE})
endif()

set_property(GLOBAL PROPERTY WATERSKY_MODULES "")

function(watersky_module name)
  cmake_parse_arguments(arg "" "" "SOURCES;LINKS;PRIVATE_LINKS;TESTS;TEST_LINKS" ${ARGN})
  set(target watersky_${name})
  if(arg_SOURCES)
    add_library(${target} STATIC ${arg_SOURCES})
    set(scope PUBLIC)
    target_link_libraries(${target} PRIVATE
      $<BUILD_INTERFACE:watersky_warnings> ${arg_PRIVATE_LINKS})
  else()
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(watersky::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(${target} ${scope}
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(${target} ${scope} cxx_std_20)
  target_link_libraries(${target} ${scope} $<BUILD_INTERFACE:watersky_options> ${arg_LINKS})
  set_property(GLOBAL APPEND PROPERTY WATERSKY_MODULES ${target})
  if(WATERSKY_TESTS AND arg_TESTS)
    watersky_test(${name}_test SOURCES ${arg_TESTS} LINKS ${target} ${arg_TEST_LINKS})
  endif()
endfunction()

# watersky_test(NAME SOURCES … LINKS …): a GoogleTest program, one CTest entry a test.
function(watersky_test name)
  cmake_parse_arguments(arg "" "" "SOURCES;LINKS" ${ARGN})
  find_package(GTest REQUIRED)
  add_executable(${name} ${arg_SOURCES})
  set_target_properties(${name} PROPERTIES
    RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin/tests)
  target_link_libraries(${name} PRIVATE
    watersky_warnings ${arg_LINKS} GTest::gmock GTest::gtest GTest::gtest_main)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_compile_definitions(${name} PRIVATE
    WATERSKY_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 600)
endfunction()

# watersky_program(NAME bench|experiments SOURCES … LINKS …)
function(watersky_program name folder)
  cmake_parse_arguments(arg "" "" "SOURCES;LINKS" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  set_target_properties(${name} PROPERTIES
    RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin/${folder})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_link_libraries(${name} PRIVATE watersky_warnings ${arg_LINKS})
endfunction()

# watersky::watersky, all modules in one name.
function(watersky_umbrella)
  get_property(modules GLOBAL PROPERTY WATERSKY_MODULES)
  add_library(watersky INTERFACE)
  add_library(watersky::watersky ALIAS watersky)
  target_link_libraries(watersky INTERFACE ${modules})
endfunction()
