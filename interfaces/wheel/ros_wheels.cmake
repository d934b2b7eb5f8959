# What a build against the ROS 2 wheels needs, and a build against an installed ROS does not.

# Makes the CMake packages of the ROS wheels in the Python environment findable.
macro(use_ros_wheels)
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  # The wheels put lib/ and share/ beside lib/pythonX.Y/, four levels above any of their modules.
  execute_process(
    COMMAND "${Python3_EXECUTABLE}" -c
      "import pathlib, rosidl_cmake; print(pathlib.Path(rosidl_cmake.__file__).parents[4])"
    OUTPUT_VARIABLE ros_wheels_prefix
    OUTPUT_STRIP_TRAILING_WHITESPACE
    RESULT_VARIABLE ros_wheels_missing)
  if(ros_wheels_missing)
    message(FATAL_ERROR "The ROS 2 wheels are not in this Python environment: "
      "'import rosidl_cmake' failed. They are build requirements in pyproject.toml.")
  endif()
  list(APPEND CMAKE_PREFIX_PATH "${ros_wheels_prefix}")
  # rosidl finds its typesupport generators through the ament index below this prefix.
  set(ENV{AMENT_PREFIX_PATH} "${ros_wheels_prefix}")
endmacro()

# Leaves out the generators of C++, half of what there is to compile. To be called after the
# generators are found.
macro(generate_for_python)
  list(FILTER AMENT_EXTENSIONS_rosidl_generate_idl_interfaces EXCLUDE REGEX "_cpp:")
endmacro()

# Has the type supports of a package loaded with it: rosidl opens them by their bare names, and would
# find them only in a folder that LD_LIBRARY_PATH names.
function(load_type_supports)
  target_link_options(${PROJECT_NAME}__rosidl_typesupport_c PRIVATE "LINKER:--no-as-needed")
  foreach(kind fastrtps_c introspection_c)
    target_link_libraries(${PROJECT_NAME}__rosidl_typesupport_c
      PRIVATE ${PROJECT_NAME}__rosidl_typesupport_${kind})
  endforeach()
endfunction()

# The wheels export a Python include folder of the machine they were built on; CMake refuses to use
# an imported target with an include folder that does not exist.
function(drop_absent_include_folders)
  get_property(targets DIRECTORY PROPERTY IMPORTED_TARGETS)
  foreach(target IN LISTS targets)
    get_target_property(folders ${target} INTERFACE_INCLUDE_DIRECTORIES)
    if(NOT folders)
      continue()
    endif()
    set(present "")
    foreach(folder IN LISTS folders)
      if(folder MATCHES "^\\$<" OR EXISTS "${folder}")
        list(APPEND present "${folder}")
      endif()
    endforeach()
    set_target_properties(${target} PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${present}")
  endforeach()
endfunction()

# Installs packages that stand in for real ones under a prefix of their own, which Python searches
# last: a real package in the same environment is then neither overwritten nor hidden, whichever of
# the two is installed first.
function(move_behind_real_packages prefix)
  string(JOIN "|" names ${ARGN})
  install(CODE "
    set(root \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}\")
    file(GLOB_RECURSE found LIST_DIRECTORIES false RELATIVE \"\${root}\" \"\${root}/*\")
    foreach(file IN LISTS found)
      if(file MATCHES \"^(lib/lib|lib/python[^/]+/site-packages/|share/)(${names})(__|/)\"
          OR file MATCHES \"^share/ament_index/.*/(${names})$\")
        get_filename_component(folder \"\${file}\" DIRECTORY)
        file(MAKE_DIRECTORY \"\${root}/${prefix}/\${folder}\")
        file(RENAME \"\${root}/\${file}\" \"\${root}/${prefix}/\${file}\")
      elseif(file MATCHES \"^lib/python[^/]+/site-packages/(${names})-|^include/(${names})/\")
        file(REMOVE \"\${root}/\${file}\")
      endif()
    endforeach()
    file(GLOB packages RELATIVE \"\${root}\" \"\${root}/lib/python*/site-packages\")
    file(WRITE \"\${root}/\${packages}/bt_mission_ros.pth\"
      \"../../../${prefix}/\${packages}\\n\")
  ")
endfunction()
