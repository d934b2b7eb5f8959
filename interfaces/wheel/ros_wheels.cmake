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
