# What an installation has beside the program, and the Debian package (scripts/package). Texts come from the program's own
# declarations: it is run after it is linked.
set(generated ${CMAKE_BINARY_DIR}/package)
add_custom_command(OUTPUT ${generated}/maquette.1 ${generated}/maquette.bash ${generated}/_maquette
  COMMAND ${CMAKE_COMMAND} -E make_directory ${generated}
  COMMAND $<TARGET_FILE:maquette> help --man > ${generated}/maquette.1
  COMMAND $<TARGET_FILE:maquette> help --completion bash > ${generated}/maquette.bash
  COMMAND $<TARGET_FILE:maquette> help --completion zsh > ${generated}/_maquette
  DEPENDS maquette COMMENT "Writing the man page and completions" VERBATIM)
find_program(GZIP gzip REQUIRED)
add_custom_command(OUTPUT ${generated}/maquette.1.gz ${generated}/changelog.gz
  COMMAND ${GZIP} -9nc ${generated}/maquette.1 > ${generated}/maquette.1.gz
  COMMAND ${GZIP} -9nc ${CMAKE_SOURCE_DIR}/CHANGELOG.md > ${generated}/changelog.gz
  COMMAND ${GZIP} -9nc ${generated}/changelog.Debian > ${generated}/changelog.Debian.gz
  DEPENDS ${generated}/maquette.1 ${CMAKE_SOURCE_DIR}/CHANGELOG.md VERBATIM)
add_custom_target(installed_texts ALL DEPENDS ${generated}/maquette.1.gz ${generated}/maquette.bash)

file(READ ${CMAKE_SOURCE_DIR}/LICENSE licence)
string(STRIP "${licence}" licence)
string(REGEX REPLACE "^MIT License\n+" "" licence "${licence}")
string(REGEX MATCH "Copyright[^\n]*" copyright "${licence}")
string(REGEX REPLACE "^Copyright *(\\([cC]\\) *)?" "" copyright "${copyright}")
string(REGEX REPLACE "^Copyright[^\n]*\n+" "" licence "${licence}")
string(REGEX REPLACE "\n\n" "\n.\n" licence "${licence}")
string(REGEX REPLACE "\n" "\n " licence "${licence}")
file(WRITE ${generated}/copyright
"Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: maquette

Files: *
Copyright: ${copyright}
License: Expat
 ${licence}
")

string(TIMESTAMP today "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(WRITE ${generated}/changelog.Debian
"maquette (${PROJECT_VERSION}-1) unstable; urgency=medium

  * Made by scripts/package; changelog.gz says what has changed.

 -- The Maquette authors <maquette@users.noreply.github.com>  ${today}
")

set(from ${CMAKE_SOURCE_DIR}/cmake/package)
install(FILES ${generated}/maquette.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${generated}/maquette.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME maquette)
install(FILES ${generated}/_maquette DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions)
install(FILES ${from}/maquette.desktop DESTINATION ${CMAKE_INSTALL_DATADIR}/applications)
install(FILES ${from}/maquette.svg DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps)
install(FILES ${from}/maquette.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/mime/packages)
install(FILES ${generated}/copyright ${generated}/changelog.gz ${generated}/changelog.Debian.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/maquette)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME maquette)
set(CPACK_PACKAGE_VENDOR "The Maquette authors")
set(CPACK_PACKAGE_CONTACT "The Maquette authors <maquette@users.noreply.github.com>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "viewer of virtual prototypes in measured materials under real light")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "Maquette loads a glTF scene, first of all a car interior, shades it with
measured materials under real environments, and says of every picture how
wrong it is. It keeps design reviews, measures what a windshield reflects, and
plays camera paths.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# What is loaded at run time, by name: OpenGL and EGL by libepoxy, Mesa's drivers by these; the font of the panels.
set(CPACK_DEBIAN_PACKAGE_DEPENDS "libegl1, libegl-mesa0, libgl1, libgl1-mesa-dri, fonts-dejavu-core")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "gnuplot-nox, ffmpeg, fonts-noto-cjk | fonts-droid-fallback")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)
