# cmake --install: PREFIX/bin (tern and the processes), PREFIX/lib/tern/tern (the Python package),
# PREFIX/share/tern (cases, docs, protocol).
# cpack -G DEB: the same as a Debian package.
set(package lib/tern/tern)
file(WRITE ${CMAKE_BINARY_DIR}/install/_installed.py [[
"""Written by the installation: where things are, seen from this folder (paths.py)."""

EXECUTABLES = "../../../bin"
SHARE = "../../../share/tern"
COMMAND = "../../../bin/tern"
]])
file(WRITE ${CMAKE_BINARY_DIR}/install/tern [[
#!/bin/sh
# tern: the launcher of an installation; everything it does is in the Python package beside.
prefix=$(dirname "$(dirname "$(readlink -f "$0")")")
PYTHONPATH=$prefix/lib/tern${PYTHONPATH:+:$PYTHONPATH} exec /usr/bin/python3 -B -P -S "$prefix/lib/tern/tern/start.py" "$@"
]])
install(TARGETS tern-case tern-fluid tern-structure tern-coupler RUNTIME DESTINATION bin)
install(PROGRAMS ${CMAKE_BINARY_DIR}/install/tern DESTINATION bin)
install(DIRECTORY python/tern/ DESTINATION ${package} PATTERN __pycache__ EXCLUDE)
install(FILES ${CMAKE_BINARY_DIR}/install/_installed.py DESTINATION ${package})
# The command is `tern` here, in help and sentences too.
install(CODE [[
  file(GLOB_RECURSE sources "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/lib/tern/tern/*.py")
  foreach(source ${sources})
    file(READ ${source} text)
    string(REPLACE "./tern " "tern " text "${text}")
    file(WRITE ${source} "${text}")
  endforeach()
]])
install(DIRECTORY cases docs DESTINATION share/tern)
install(FILES README.md proto/wire/tern.proto DESTINATION share/tern)
install(FILES LICENSE DESTINATION share/doc/tern RENAME copyright)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME tern)
set(CPACK_PACKAGE_CONTACT "the tern authors <tern@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Fluid-structure simulation with particles")
set(CPACK_PACKAGE_DESCRIPTION
  "Incompressible SPH for the fluid, total-Lagrangian SPH for the structure, and a coupler between them: three processes, one simulation.
 Compiled for ${TERN_ARCHITECTURE}.")
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "python3 (>= 3.11)")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3-numpy, python3-matplotlib, python3-h5py, python3-markdown, python3-pil")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "ffmpeg, python3-vtk9, xvfb, python3-zmq, python3-protobuf, protobuf-compiler")
include(CPack)
