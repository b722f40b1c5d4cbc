# SPDX-License-Identifier: Apache-2.0
# find_package(mehvar): generated C as targets. Needs the folder runtime/native of an installed mehvar, nothing else of it.

get_filename_component(mehvar_include "${CMAKE_CURRENT_LIST_DIR}/../include" ABSOLUTE)

# A static library `mehvar::MODEL` from a generated folder: the model and what the headers need, at one lane.
function(mehvar_add_model model folder)
  add_library(mehvar_${model} STATIC "${folder}/${model}.c")
  add_library(mehvar::${model} ALIAS mehvar_${model})
  target_include_directories(mehvar_${model} PUBLIC "${mehvar_include}" "${folder}")
  target_compile_features(mehvar_${model} PRIVATE c_std_99)
  if(NOT MSVC)
    # the same bits everywhere: see docs/reference/generated-c.md; MSVC does not contract unless it is told to
    target_compile_options(mehvar_${model} PRIVATE -ffp-contract=off -fno-math-errno)
    target_link_libraries(mehvar_${model} PUBLIC m)
  endif()
endfunction()
