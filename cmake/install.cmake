# What `cmake --install` and `cpack -G DEB` put in place: the program, its manual page and shell completions (which the
# program itself prints), specs as examples with their schemas and some recordings of real machines, the documentation,
# and the licences of all that.
include(GNUInstallDirs)

set(page ${CMAKE_BINARY_DIR}/generated/bayesctrl.1)
set(completions bash/bayesctrl zsh/_bayesctrl fish/bayesctrl.fish)
list(TRANSFORM completions PREPEND ${CMAKE_BINARY_DIR}/generated/completion/)
set(commands COMMAND bayesctrl man > ${page})
foreach(script IN LISTS completions)
  get_filename_component(folder ${script} DIRECTORY)
  get_filename_component(shell ${folder} NAME)
  list(APPEND commands COMMAND ${CMAKE_COMMAND} -E make_directory ${folder} COMMAND bayesctrl completion ${shell} > ${script})
endforeach()
add_custom_command(OUTPUT ${page} ${completions} ${commands} DEPENDS bayesctrl VERBATIM)
add_custom_target(help_files ALL DEPENDS ${page} ${completions})

# The script that CMake makes of the rules below names every file by its absolute path. Where the build directory has been
# moved or copied, it first writes itself anew with the paths of today: the source is looked for at the same place relative
# to the build directory, then where it was.
file(RELATIVE_PATH way_to_source ${CMAKE_BINARY_DIR} ${CMAKE_SOURCE_DIR})
install(CODE "
set(build \"${CMAKE_BINARY_DIR}/\")
set(source \"${CMAKE_SOURCE_DIR}/\")
set(way_to_source \"${way_to_source}\")" ALL_COMPONENTS)
install(CODE [[
file(REAL_PATH "${CMAKE_CURRENT_LIST_DIR}" build_now)
file(REAL_PATH "${build_now}/${way_to_source}" source_now)
file(REAL_PATH "${build}" build_then)
if(NOT build_now STREQUAL build_then)
  file(READ "${CMAKE_CURRENT_LIST_FILE}" script)
  string(REPLACE "\"${build}" "\"<build>/" script "${script}")
  if(EXISTS "${source_now}/cmake/install.cmake")
    string(REPLACE "\"${source}" "\"${source_now}/" script "${script}")
  endif()
  string(REPLACE "\"<build>/" "\"${build_now}/" script "${script}")
  file(WRITE "${build_now}/cmake_install.cmake" "${script}")
  include("${build_now}/cmake_install.cmake")
  return()
endif()]] ALL_COMPONENTS)

install(TARGETS bayesctrl RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(FILES ${page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${CMAKE_BINARY_DIR}/generated/completion/bash/bayesctrl DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(FILES ${CMAKE_BINARY_DIR}/generated/completion/fish/bayesctrl.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
# zsh looks into site-functions; what Debian's packages bring stands in vendor-completions.
set(zsh_completion ${CMAKE_BINARY_DIR}/generated/completion/zsh/_bayesctrl)
install(FILES ${zsh_completion} DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions COMPONENT site)
install(FILES ${zsh_completion} DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions COMPONENT debian EXCLUDE_FROM_ALL)
install(DIRECTORY configs/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} FILES_MATCHING PATTERN *.md)
install(FILES README.md CHANGELOG.md LICENSE cmake/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES lib/report/assets/uplot/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR}/notices RENAME uPlot)

set(CPACK_GENERATOR DEB)
set(here "\${CMAKE_CURRENT_LIST_DIR}") # of CPackConfig.cmake: the build directory, wherever it is by then
set(CPACK_INSTALL_CMAKE_PROJECTS "${here};bayesctrl;Unspecified;/;${here};bayesctrl;debian;/")
set(CPACK_PACKAGE_NAME bayesctrl)
set(CPACK_PACKAGE_VENDOR bayesctrl)
set(CPACK_PACKAGE_CONTACT "bayesctrl maintainers")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "batch experiments of Bayesian adaptive control, and diagnosis of models")
set(CPACK_PACKAGE_DESCRIPTION "Runs experiments of Bayesian adaptive control of mechanical systems from YAML specs,
and says whether, where and why recordings of a real machine differ from its model.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON) # asks dpkg-shlibdeps which packages hold the libraries
include(CPack)
