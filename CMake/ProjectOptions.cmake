# Also included by projects that build our modules in their own tree, whatever policies they set.
cmake_policy(VERSION 3.18)

# The options of every target of this project, on one interface target. (Core adds -Wpedantic, which
# the macros of VTK's classes do not bear.)
add_library(IsosurfaceOptions INTERFACE)
target_compile_features(IsosurfaceOptions INTERFACE cxx_std_17)

option(ISOSURFACE_WARNINGS_AS_ERRORS "Treat compiler warnings as errors" OFF)
set(ISOSURFACE_SANITIZERS "" CACHE STRING
  "Sanitizers to build with, as -fsanitize takes them (address,undefined or thread)")
option(ISOSURFACE_CLANG_TIDY "Run clang-tidy beside the compiler" OFF)
option(ISOSURFACE_FUZZING "Build Core and the fuzz targets for libFuzzer (clang)" OFF)
set(ISOSURFACE_FUZZING_ENGINE "" CACHE STRING
  "What fuzz targets are linked with in place of libFuzzer; sanitizers are those of CMAKE_CXX_FLAGS then")

target_compile_options(IsosurfaceOptions INTERFACE
  -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual
  # The same results on every machine and in every build of a kernel: no fused multiply-add.
  -ffp-contract=off)
if(ISOSURFACE_WARNINGS_AS_ERRORS)
  target_compile_options(IsosurfaceOptions INTERFACE -Werror)
endif()
if(ISOSURFACE_FUZZING)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    message(FATAL_ERROR "ISOSURFACE_FUZZING needs clang, for its libFuzzer")
  endif()
  if(NOT ISOSURFACE_FUZZING_ENGINE)
    set(ISOSURFACE_SANITIZERS "fuzzer-no-link,address,undefined")
  endif()
endif()
if(ISOSURFACE_SANITIZERS)
  target_compile_options(IsosurfaceOptions INTERFACE
    -fsanitize=${ISOSURFACE_SANITIZERS} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  if(ISOSURFACE_SANITIZERS MATCHES "undefined")
    # A null pointer ends the program by itself; checks of each use are a tenth of the time to compile.
    target_compile_options(IsosurfaceOptions INTERFACE -fno-sanitize=null)
    # With GCC, checks of each use of any pointer are a quarter; AddressSanitizer sees what goes astray.
    # Fuzzers (clang) have them. What sanitizers leave of an empty std::optional then looks uninitialized.
    target_compile_options(IsosurfaceOptions INTERFACE
      "$<$<CXX_COMPILER_ID:GNU>:-fno-sanitize=alignment,object-size,pointer-overflow;-Wno-maybe-uninitialized>")
  endif()
  if(NOT ISOSURFACE_LONG_TESTS)
    # With GCC, looking at each variable that leaves its scope is a third of the time to compile: that is for
    # fuzzers (clang) and long tests.
    target_compile_options(IsosurfaceOptions INTERFACE
      $<$<CXX_COMPILER_ID:GNU>:-fno-sanitize-address-use-after-scope>)
  endif()
  target_link_options(IsosurfaceOptions INTERFACE -fsanitize=${ISOSURFACE_SANITIZERS})
endif()
if(ISOSURFACE_CLANG_TIDY)
  find_program(ISOSURFACE_CLANG_TIDY_PROGRAM clang-tidy REQUIRED)
  # Its own default may be an older standard than the compiler's, which CMake then does not name.
  set(isosurface_clang_tidy
    "${ISOSURFACE_CLANG_TIDY_PROGRAM};--quiet;--extra-arg-before=-std=c++17")
endif()

# One room: an object library whose sources are part of a library, IsosurfaceCore if it is not said. Rooms
# of Core see Core alone.
#   isosurface_add_room(<name> [LIBRARY <target>] SOURCES <files> [LINK <libraries>])
function(isosurface_add_room name)
  cmake_parse_arguments(room "" "LIBRARY" "SOURCES;LINK" ${ARGN})
  set(folders "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/../Core")
  if(room_LIBRARY)
    list(APPEND folders "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/..")
  else()
    set(room_LIBRARY IsosurfaceCore)
  endif()
  add_library(${name} OBJECT ${room_SOURCES})
  target_include_directories(${name} PUBLIC "$<BUILD_INTERFACE:${folders}>")
  target_link_libraries(${name} PUBLIC Threads::Threads PRIVATE IsosurfaceOptions ${room_LINK})
  target_compile_options(${name} PRIVATE -Wpedantic)
  set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  if(ISOSURFACE_CLANG_TIDY)
    set_target_properties(${name} PROPERTIES CXX_CLANG_TIDY "${isosurface_clang_tidy}")
  endif()
  target_sources(${room_LIBRARY} PRIVATE $<TARGET_OBJECTS:${name}>)
  if(room_LIBRARY MATCHES "^Isosurface(Core|Formats)$")
    target_sources(IsosurfaceStatic PRIVATE $<TARGET_OBJECTS:${name}>)
  endif()
  target_link_libraries(${room_LIBRARY} PRIVATE ${room_LINK})
endfunction()

# A library that shows nothing but the symbols of a version script, and has its own copy of what it uses of
# IsosurfaceStatic.
function(isosurface_hide_rooms library script)
  target_link_libraries(${library} PRIVATE IsosurfaceStatic)
  target_link_options(${library} PRIVATE "LINKER:--version-script=${script}")
  set_target_properties(${library} PROPERTIES LINK_DEPENDS "${script}")
endfunction()

# A VTK module of this project: on top of Core, with the project's options.
function(isosurface_configure_module module)
  vtk_module_link(${module} PUBLIC isosurface::Core PRIVATE IsosurfaceOptions)
  if(ISOSURFACE_CLANG_TIDY)
    vtk_module_set_property(${module} PROPERTY CXX_CLANG_TIDY VALUE ${isosurface_clang_tidy})
  endif()
endfunction()
