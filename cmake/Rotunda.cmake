# What every target of the house shares: language, warnings, sanitizers, where programs land.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)

option(ROTUNDA_SANITIZE "build with AddressSanitizer and UndefinedBehaviorSanitizer" OFF)

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
  set(CMAKE_C_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

add_library(rotunda_options INTERFACE)
target_compile_options(rotunda_options INTERFACE -Wall -Wextra -Wconversion -Wshadow -Werror
  -Wno-missing-field-initializers)
target_include_directories(rotunda_options INTERFACE ${CMAKE_SOURCE_DIR})
if(ROTUNDA_SANITIZE)
  add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
endif()

# rotunda_floor(NAME LINKS...): the static library of one floor; its rooms add their sources with
# target_sources() from their own CMakeLists.txt.
function(rotunda_floor NAME)
  add_library(rotunda_${NAME} STATIC)
  add_library(rotunda::${NAME} ALIAS rotunda_${NAME})
  target_link_libraries(rotunda_${NAME} PUBLIC rotunda_options ${ARGN})
endfunction()

# rotunda_program(NAME FLOOR SOURCES...): a thin program on top of a floor.
function(rotunda_program NAME FLOOR)
  add_executable(${NAME} ${ARGN})
  target_link_libraries(${NAME} PRIVATE rotunda::${FLOOR})
endfunction()
