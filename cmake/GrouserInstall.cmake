# find_package(grouser CONFIG COMPONENTS terrain bekker dem sdem vehicle diagnosis models bullet): targets grouser::<component>.
include(CMakePackageConfigHelpers)
set(GROUSER_INSTALL_CMAKEDIR ${CMAKE_INSTALL_LIBDIR}/cmake/grouser)

# bullet: the header-only adapter. It brings no Bullet: link your own, in the precision you use.
add_library(grouser_bullet INTERFACE)
add_library(grouser::bullet ALIAS grouser_bullet)
set_target_properties(grouser_bullet PROPERTIES EXPORT_NAME bullet)
target_link_libraries(grouser_bullet INTERFACE grouser::terrain)
install(TARGETS grouser_bullet EXPORT grouserTargets)

set(GROUSER_COMPONENTS terrain bullet models)
if(GROUSER_BEKKER)
  list(APPEND GROUSER_COMPONENTS bekker)
endif()
if(GROUSER_DEM)
  list(APPEND GROUSER_COMPONENTS dem)
endif()
if(TARGET grouser_sdem)
  list(APPEND GROUSER_COMPONENTS sdem)
endif()
if(GROUSER_VEHICLE)
  list(APPEND GROUSER_COMPONENTS vehicle)
endif()
if(TARGET grouser_diagnosis)
  list(APPEND GROUSER_COMPONENTS diagnosis)
endif()

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/grouserConfig.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/grouserConfig.cmake
                              INSTALL_DESTINATION ${GROUSER_INSTALL_CMAKEDIR})
# 0.x: a new minor version may change the interface.
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/grouserConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/grouserConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/grouserConfigVersion.cmake
        DESTINATION ${GROUSER_INSTALL_CMAKEDIR})
install(EXPORT grouserTargets NAMESPACE grouser:: DESTINATION ${GROUSER_INSTALL_CMAKEDIR})

# Soils, wheels, grounds and vehicles that scenarios name by file; the grouser command looks here.
foreach(folder soils wheels grounds vehicles)
  if(EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/examples/${folder})
    install(DIRECTORY examples/${folder} DESTINATION ${CMAKE_INSTALL_DATADIR}/grouser)
  endif()
endforeach()
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/grouser)

# `tidy`: clang-tidy with the profile .clang-tidy over the sources of this build (GROUSER_TIDY_FILES: a regular expression of paths).
find_program(GROUSER_RUN_TIDY NAMES run-clang-tidy run-clang-tidy-14)
if(GROUSER_RUN_TIDY)
  set(GROUSER_TIDY_FILES "${PROJECT_SOURCE_DIR}/(terrain|bekker|dem|sdem|vehicle|diagnosis|app)/.*[.]cpp$" CACHE STRING "files for the target tidy")
  add_custom_target(tidy COMMAND ${GROUSER_RUN_TIDY} -quiet -extra-arg=-Wno-unknown-warning-option -p ${CMAKE_BINARY_DIR} ${GROUSER_TIDY_FILES}
                    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} USES_TERMINAL VERBATIM)
endif()
