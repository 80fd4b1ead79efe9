# What `cmake --install` and `cpack -G DEB` put in place: the program, its manual page and shell completions (which the
# program itself prints), specs as examples with their schemas, the guide, and the notices of what the program contains.
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

install(TARGETS bayesctrl RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(FILES ${page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${CMAKE_BINARY_DIR}/generated/completion/bash/bayesctrl DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(FILES ${CMAKE_BINARY_DIR}/generated/completion/zsh/_bayesctrl DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)
install(FILES ${CMAKE_BINARY_DIR}/generated/completion/fish/bayesctrl.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
install(DIRECTORY configs/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples)
install(FILES README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES lib/report/assets/uplot/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR}/notices RENAME uPlot)

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
