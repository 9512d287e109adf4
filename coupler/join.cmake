option(SUNDER_JOINED "Compile files of a folder together: all takes less time, one change more" ON)

# The target's files are compiled together, up to eight of a folder at a time: headers are then read, and templates made,
# once. What such a file keeps to itself needs a name that no other file of its folder has. Files with options of their own,
# and those that match `alone`, stay by themselves. Neighbours do not change what a file computes: products and sums are not
# fused (CMakeLists.txt), but in the kernels, which are not joined.
function(sunder_join target)
  cmake_parse_arguments(PARSE_ARGV 1 join "" ALONE "")
  if(NOT SUNDER_JOINED)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "\\.cpp$")
  if(join_ALONE)
    list(FILTER sources EXCLUDE REGEX "${join_ALONE}")
  endif()
  foreach(source ${sources})
    get_filename_component(folder ${source} DIRECTORY)
    string(MAKE_C_IDENTIFIER "in_${folder}" folder)
    math(EXPR part "0${${folder}} / 8")
    math(EXPR ${folder} "0${${folder}} + 1")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${folder}_${part})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()
