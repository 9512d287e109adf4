option(SUNDER_JOINED "Compile files that only read, check and write together: all takes less time, one change more" ON)

# The target's files that match `which` are compiled together, up to eight of a folder at a time: headers are then read, and
# templates made, once. What such a file keeps to itself needs a name that no other file of its folder has. `which` leaves out
# what computes the state of a run: neighbours decide what the compiler puts inline, and so how products and sums are fused.
function(sunder_join target which)
  if(NOT SUNDER_JOINED)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "${which}")
  foreach(source ${sources})
    get_filename_component(folder ${source} DIRECTORY)
    string(MAKE_C_IDENTIFIER "in_${folder}" folder)
    math(EXPR part "0${${folder}} / 8")
    math(EXPR ${folder} "0${${folder}} + 1")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${folder}_${part})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()
