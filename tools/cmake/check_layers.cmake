# SPDX-License-Identifier: MIT
# cmake -DROOT=DIR -P check_layers.cmake: fails when a module includes what it may not know. System headers
# are always on the include path, so the targets' links alone do not catch this.

set(failures "")

# forbid(MODULE REASON REGEX...): no #include of the module's files may match a regex.
function(forbid module reason)
  file(GLOB_RECURSE files ${ROOT}/${module}/*.h ${ROOT}/${module}/*.cpp)
  if(NOT files)
    message(FATAL_ERROR "no source files in ${module}: is ROOT right?")
  endif()
  foreach(file IN LISTS files)
    file(STRINGS ${file} includes REGEX "^[ \t]*#[ \t]*include")
    foreach(line IN LISTS includes)
      foreach(regex IN LISTS ARGN)
        if(line MATCHES "${regex}")
          string(APPEND failures "${file}: ${line} (${module} ${reason})\n")
        endif()
      endforeach()
    endforeach()
  endforeach()
  set(failures "${failures}" PARENT_SCOPE)
endfunction()

set(gl "[<\"](GLES[0-9]*|EGL|GL|KHR)/" "\"ig/gl/")
set(sockets "<sys/socket" "<netinet/" "<arpa/" "<netdb" "\"hostif/")
set(files "<fstream" "<cstdio" "<filesystem" "<fcntl" "<unistd" "<sys/stat" "\"ig/data/")
set(protocol "\"hostif/" "<sys/socket" "<netinet/" "<arpa/")

forbid(ig/base "knows nobody" "\"(ig/(geo|lod|scene|data|gl|out|app)|hostif|config|tools)/" ${gl})
forbid(ig/geo "knows base only" "\"(ig/(lod|scene|data|gl|out|app)|hostif|config|tools)/" ${gl})
forbid(ig/lod "knows no GL" ${gl})
forbid(ig/lod "knows no sockets" ${sockets})
forbid(ig/lod "knows no files" ${files})
forbid(ig/lod "knows geo only" "\"(ig/(scene|out|app)|config|tools)/")
forbid(ig/scene "knows geo only" ${gl} ${sockets} ${files} "\"(ig/(lod|out|app)|config|tools)/")
forbid(ig/data "knows no GL" ${gl} ${protocol} "\"(ig/(scene|out|app)|config|tools)/" "<gdal")
forbid(ig/gl "knows no protocol" ${protocol} "\"(ig/(scene|out|app)|config|tools)/")
forbid(ig/out "knows base only" ${gl} ${protocol} "\"(ig/(geo|lod|scene|data|app)|config|tools)/")
forbid(hostif "knows ig/base only" ${gl} "\"(ig/(geo|lod|scene|data|gl|out|app)|config|tools)/" "<glm")
forbid(config "knows ig/base only" ${gl} ${sockets} "\"(ig/(geo|lod|scene|data|gl|out|app)|tools)/")

if(failures)
  message(FATAL_ERROR "layering broken:\n${failures}")
endif()
message(STATUS "layers: nothing is included against the flow")
