# grouser_module(name SOURCES ... PUBLIC ... PRIVATE ...): one static library grouser_<name>, alias grouser::<name>.
function(grouser_warnings target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
                         $<$<BOOL:${GROUSER_WERROR}>:-Werror>)
  if(GROUSER_SANITIZE)
    # GCC's flow warnings are unreliable in instrumented code (its manual says so); here they fire inside std::regex.
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
    target_compile_options(${target} PUBLIC -fsanitize=${GROUSER_SANITIZE} -fno-omit-frame-pointer)
    target_link_options(${target} PUBLIC -fsanitize=${GROUSER_SANITIZE})
  endif()
endfunction()

function(grouser_module name)
  cmake_parse_arguments(M "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(grouser_${name} STATIC ${M_SOURCES})
  add_library(grouser::${name} ALIAS grouser_${name})
  target_include_directories(grouser_${name} PUBLIC
    $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(grouser_${name} PUBLIC cxx_std_20)
  target_link_libraries(grouser_${name} PUBLIC ${M_PUBLIC} PRIVATE ${M_PRIVATE})
  set_target_properties(grouser_${name} PROPERTIES EXPORT_NAME ${name})
  grouser_warnings(grouser_${name})
  install(TARGETS grouser_${name} EXPORT grouserTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  if(EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/include)
    install(DIRECTORY include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  endif()
endfunction()
