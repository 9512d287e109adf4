// Nothing but the headers that the tests of a library have in common (CMakeLists.txt).
