# Rooms: static libraries that see nothing but their own headers and those of the rooms they depend on.
#
# A room's headers are reached through a directory of links of its own (build/.../rooms/NAME), never through the source tree, so that
# including the header of a room that is not declared as a dependency does not compile (tests/layers).

# tern_room(NAME SOURCE_DIRECTORIES dir ... [HEADERS_ONLY] [DEPENDS target ...])
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
  else()
    add_library(tern_${name} INTERFACE)
    target_include_directories(tern_${name} INTERFACE ${links})
    target_link_libraries(tern_${name} INTERFACE ${ROOM_DEPENDS})
  endif()
endfunction()
