option(SUNDER_JOINED "Compile the files of a folder together: all takes a third less time, one change more" ON)

# Files of one folder are compiled together, up to eight at a time: headers are then read, and templates made, once. What a
# file keeps to itself needs a name that no other file of its folder has. A file whose path matches `alone` is compiled by
# itself: no neighbour decides then what the compiler puts inline in its loops.
function(sunder_join target alone)
  if(NOT SUNDER_JOINED)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "\\.cpp$")
  list(FILTER sources EXCLUDE REGEX "${alone}")
  foreach(source ${sources})
    get_filename_component(folder ${source} DIRECTORY)
    string(MAKE_C_IDENTIFIER "in_${folder}" folder)
    math(EXPR part "0${${folder}} / 8")
    math(EXPR ${folder} "0${${folder}} + 1")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${folder}_${part})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()
