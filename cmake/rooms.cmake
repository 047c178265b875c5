# Rooms: static libraries that see nothing but their own headers and those of the rooms they depend on.
#
# A room's headers are reached through a directory of links of its own (build/.../rooms/NAME), never through the source tree, so that
# including the header of a room that is not declared as a dependency does not compile (tests/layers/layers_test.py).

# tern_precompiled(TARGET): its sources begin with the headers of libraries that most sources include. The first target makes the file.
# Reading them is most of the time of a build. -DTERN_PRECOMPILED=OFF shows a header that a source forgets to include.
# The standard headers among them bring in names that a call on a std type finds by its argument: do not call a function `quoted`.
# Sources are never joined into one unit (UNITY_BUILD): functions of one name in the anonymous namespaces of two of them would be
# overloads of each other, and a call could take the other's without a word of the compiler.
function(tern_precompiled target)
  if(NOT TERN_PRECOMPILED)
    return()
  endif()
  get_property(first GLOBAL PROPERTY TERN_PRECOMPILED_BY)
  if(first)
    target_precompile_headers(${target} REUSE_FROM ${first})
  else()
    set_property(GLOBAL PROPERTY TERN_PRECOMPILED_BY ${target})
    target_precompile_headers(${target} PRIVATE <algorithm> <cmath> <filesystem> <functional> <map> <string> <vector>
                              <Eigen/Dense> <fmt/format.h> <fmt/ranges.h>)
  endif()
endfunction()

# tern_room(NAME DIRECTORIES dir ... [DEPENDS target ...])
# The headers and sources directly in each directory (not below it) are the room.
function(tern_room name)
  cmake_parse_arguments(ROOM "" "" "DIRECTORIES;DEPENDS" ${ARGN})
  set(links ${CMAKE_BINARY_DIR}/rooms/${name})
  file(REMOVE_RECURSE ${links})
  set(sources)
  foreach(directory ${ROOM_DIRECTORIES})
    file(GLOB headers CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/${directory}/*.hpp)
    file(GLOB own CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/${directory}/*.cpp)
    list(APPEND sources ${own})
    file(MAKE_DIRECTORY ${links}/${directory})
    foreach(header ${headers})
      get_filename_component(file ${header} NAME)
      file(CREATE_LINK ${header} ${links}/${directory}/${file} SYMBOLIC)
    endforeach()
  endforeach()
  list(FILTER sources EXCLUDE REGEX "/main\\.cpp$")
  if(sources)
    add_library(tern_${name} STATIC ${sources})
    target_include_directories(tern_${name} PUBLIC ${links})
    target_link_libraries(tern_${name} PUBLIC ${ROOM_DEPENDS})
    tern_precompiled(tern_${name})
  else()
    add_library(tern_${name} INTERFACE)
    target_include_directories(tern_${name} INTERFACE ${links})
    target_link_libraries(tern_${name} INTERFACE ${ROOM_DEPENDS})
  endif()
  set_property(GLOBAL APPEND PROPERTY TERN_ROOMS ${name})
  set_property(TARGET tern_${name} PROPERTY TERN_DIRECTORIES ${ROOM_DIRECTORIES})
endfunction()
