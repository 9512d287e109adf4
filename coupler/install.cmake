# What `cmake --install` puts where, and the Debian package that cpack makes of it.
#   bin/sunder                     the command
#   libexec/sunder/<level>/        the programs, one folder for each instruction set; the command chooses (launch/level.py)
#   share/sunder/                  Python, viewer, scenes, proto, pages: as in a checkout, so that all is found alike
#   lib/python3/dist-packages/     what scripts import
set(SUNDER_PYTHON_DIR lib/python3/dist-packages CACHE STRING "Where python3 looks for packages, below the prefix")
set(share share/sunder)

install(TARGETS sunder-shell sunder-rigid sunder-single DESTINATION libexec/sunder/${SUNDER_ARCH})
# Whole programs for each further level, in build trees of their own.
include(ExternalProject)
foreach(level ${SUNDER_LEVELS})
  ExternalProject_Add(${level} SOURCE_DIR ${CMAKE_SOURCE_DIR} BINARY_DIR ${CMAKE_BINARY_DIR}/${level} PREFIX ${level}-steps
    CMAKE_ARGS -DCMAKE_BUILD_TYPE=${CMAKE_BUILD_TYPE} -DCMAKE_CXX_COMPILER=${CMAKE_CXX_COMPILER}
      "-DCMAKE_CXX_FLAGS_RELEASE=${CMAKE_CXX_FLAGS_RELEASE}" -DSUNDER_ARCH=${level} -DSUNDER_CAD=${SUNDER_CAD} -DBUILD_TESTING=OFF
    INSTALL_COMMAND "" BUILD_ALWAYS TRUE USES_TERMINAL_BUILD TRUE)
  install(PROGRAMS ${CMAKE_BINARY_DIR}/${level}/shell/sunder-shell ${CMAKE_BINARY_DIR}/${level}/rigid/sunder-rigid
    ${CMAKE_BINARY_DIR}/${level}/coupler/single/sunder-single DESTINATION libexec/sunder/${level})
endforeach()

install(DIRECTORY coupler/sunder_tools coupler/sunder_lab coupler/sunder_engine coupler/experiments coupler/viewer coupler/blender
  DESTINATION ${share}/coupler
  PATTERN __pycache__ EXCLUDE)
install(PROGRAMS coupler/sunder DESTINATION ${share}/coupler)
install(FILES coupler/sunder.py coupler/README.md DESTINATION ${share}/coupler)
install(DIRECTORY scenes proto DESTINATION ${share} PATTERN __pycache__ EXCLUDE PATTERN CMakeLists.txt EXCLUDE)
install(DIRECTORY rigid/jolt rigid/mujoco DESTINATION ${share}/rigid USE_SOURCE_PERMISSIONS)
install(FILES rigid/README.md DESTINATION ${share}/rigid)
install(FILES README.md LICENCE DESTINATION ${share})
file(WRITE ${CMAKE_BINARY_DIR}/VERSION "${PROJECT_VERSION}\n")
install(FILES ${CMAKE_BINARY_DIR}/VERSION DESTINATION ${share}/coupler)  # its being there says that this is no checkout

# Python follows these links to share/sunder, where the rest is.
function(install_link target where)
  get_filename_component(folder ${where} DIRECTORY)
  install(CODE "file(MAKE_DIRECTORY \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${folder}\")
    file(CREATE_LINK ${target} \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${where}\" SYMBOLIC)")
endfunction()
string(REGEX REPLACE "[^/]+" ".." up ${SUNDER_PYTHON_DIR})
foreach(module sunder.py sunder_lab sunder_engine sunder_tools)
  install_link(${up}/${share}/coupler/${module} ${SUNDER_PYTHON_DIR}/${module})
endforeach()
install_link(../${share}/coupler/sunder bin/sunder)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_CONTACT "The Sunder developers <sunder@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_STRIP_FILES TRUE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# protoc: sunder_lab and sunder_engine make their messages from the schemas.
set(CPACK_DEBIAN_PACKAGE_DEPENDS "python3, python3-numpy, python3-pil, python3-protobuf, protobuf-compiler")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "ffmpeg, nodejs, fonts-dejavu-core")
include(CPack)
