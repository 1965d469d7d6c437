# fos::fos: the static library of the C interface, with its header.
#
#   find_package(fos CONFIG REQUIRED)      # with fos_DIR=…/fos-embedded/cmake
#   target_link_libraries(firmware PRIVATE fos::fos)
#
# What can be set before:
#
#   FOS_ARCHIVE           the archive, if it was built before; otherwise cargo builds it
#   FOS_TARGET            Rust's name of the target; otherwise found from the flags of the C compiler, or the host
#   FOS_CARGO_TARGET_DIR  where cargo builds; otherwise fos in the build directory
include_guard(GLOBAL)

get_filename_component(FOS_DIRECTORY "${CMAKE_CURRENT_LIST_DIR}/.." ABSOLUTE)

# Rust's name of a bare Cortex-M or RISC-V core, from the flags that C is compiled with.
function(fos_target_of_flags flags result)
  set(target "")
  set(float "")
  if(flags MATCHES "-mfloat-abi=hard")
    set(float "hf")
  endif()
  if(flags MATCHES "-mcpu=cortex-m(0|0plus|1)([ +]|$)")
    set(target thumbv6m-none-eabi)
  elseif(flags MATCHES "-mcpu=cortex-m3([ +]|$)")
    set(target thumbv7m-none-eabi)
  elseif(flags MATCHES "-mcpu=cortex-m(4|7)([ +]|$)")
    set(target thumbv7em-none-eabi${float})
  elseif(flags MATCHES "-mcpu=cortex-m23([ +]|$)")
    set(target thumbv8m.base-none-eabi)
  elseif(flags MATCHES "-mcpu=cortex-m(33|35p|55|85)([ +]|$)")
    set(target thumbv8m.main-none-eabi${float})
  elseif(flags MATCHES "-march=rv32(i|g)([a-y]*)")
    # g is imafd with two more, and the calling convention says where floats go
    string(REPLACE "g" "imafd" letters "${CMAKE_MATCH_1}${CMAKE_MATCH_2}")
    if(flags MATCHES "-mabi=ilp32f([ ]|$)" AND letters MATCHES "m.*a.*c")
      set(target riscv32imafc-unknown-none-elf)
    elseif(flags MATCHES "-mabi=ilp32([ ]|$)" AND letters MATCHES "m.*a.*c")
      set(target riscv32imac-unknown-none-elf)
    elseif(flags MATCHES "-mabi=ilp32([ ]|$)" AND letters MATCHES "m.*c")
      set(target riscv32imc-unknown-none-elf)
    endif()
  endif()
  if(NOT target)
    message(FATAL_ERROR "fos: no core among the C flags (${flags}) for which there is a target of Rust; set FOS_TARGET to its name")
  endif()
  set(${result} ${target} PARENT_SCOPE)
endfunction()

add_library(fos::fos STATIC IMPORTED GLOBAL)

if(NOT FOS_TARGET AND CMAKE_SYSTEM_NAME STREQUAL "Generic")
  get_directory_property(fos_options COMPILE_OPTIONS)
  string(REPLACE ";" " " fos_flags "${CMAKE_C_FLAGS} ${fos_options}")
  fos_target_of_flags("${fos_flags}" FOS_TARGET)
endif()

if(NOT FOS_ARCHIVE)
  find_program(FOS_CARGO cargo REQUIRED)
  if(NOT FOS_CARGO_TARGET_DIR)
    set(FOS_CARGO_TARGET_DIR "${CMAKE_BINARY_DIR}/fos")
  endif()
  if(FOS_TARGET)
    set(fos_arguments --profile device --target ${FOS_TARGET})
    set(FOS_ARCHIVE "${FOS_CARGO_TARGET_DIR}/${FOS_TARGET}/device/libfos_embedded.a")
  else()
    set(fos_arguments --release)
    set(FOS_ARCHIVE "${FOS_CARGO_TARGET_DIR}/release/libfos_embedded.a")
  endif()
  # at every build: cargo itself knows what has changed
  add_custom_target(fos_cargo
    COMMAND "${FOS_CARGO}" rustc --quiet --package fos-embedded --lib --features c-api --crate-type staticlib
            --target-dir "${FOS_CARGO_TARGET_DIR}" ${fos_arguments}
    WORKING_DIRECTORY "${FOS_DIRECTORY}"
    BYPRODUCTS "${FOS_ARCHIVE}"
    COMMENT "fos: static library"
    VERBATIM)
  add_dependencies(fos::fos fos_cargo)
endif()

set_target_properties(fos::fos PROPERTIES
  IMPORTED_LOCATION "${FOS_ARCHIVE}"
  INTERFACE_INCLUDE_DIRECTORIES "${FOS_DIRECTORY}/include")
if(FOS_TARGET MATCHES "-none-")
  # the archive has one section a function, and most of its arithmetic is not needed
  set_target_properties(fos::fos PROPERTIES INTERFACE_LINK_OPTIONS "-Wl,--gc-sections")
else()
  # on a host the standard library of Rust is in it
  find_package(Threads REQUIRED)
  set_target_properties(fos::fos PROPERTIES INTERFACE_LINK_LIBRARIES "Threads::Threads;${CMAKE_DL_LIBS};m")
endif()
