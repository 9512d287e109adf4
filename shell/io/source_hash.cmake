# Writes OUTPUT: the function source_hash() with a SHA-256 over the C++ sources below TOP/shell, TOP/coupler and TOP/rigid.
# It is written only where it changes.
file(GLOB_RECURSE sources RELATIVE ${TOP} ${TOP}/shell/*.h ${TOP}/shell/*.cpp ${TOP}/coupler/*.h ${TOP}/coupler/*.cpp
  ${TOP}/rigid/*.h ${TOP}/rigid/*.cpp)
list(SORT sources)
set(all "")
foreach(source ${sources})
  file(SHA256 ${TOP}/${source} hash)
  string(APPEND all "${source} ${hash}\n")
endforeach()
string(SHA256 hash "${all}")
set(text "#include \"shell/io/checkpoint_file.h\"\n\nconst char* sunder::shell::source_hash() { return \"${hash}\"; }\n")
set(old "")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} old)
endif()
if(NOT old STREQUAL text)
  file(WRITE ${OUTPUT} "${text}")
endif()
