# How a folder under pie/ becomes a library: pie_module(level SOURCES bsp.cpp … DEPENDS core PUBLIC OpenImageIO PRIVATE zip)
# The dependencies are the layering of doc/architecture.md: a folder links, and so includes, only what stands above it in the flow.

add_library(pie_flags INTERFACE)
target_compile_features(pie_flags INTERFACE cxx_std_20)
# Same seed, same bits: no contraction to fused multiply-adds that one compiler makes and another does not.
target_compile_options(pie_flags INTERFACE -ffp-contract=off -fno-math-errno)

add_library(pie_warnings INTERFACE)
target_compile_options(pie_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual
                                              -Wold-style-cast $<$<BOOL:${PIE_WERROR}>:-Werror>)
if(CMAKE_UNITY_BUILD)
    # Sources compiled together see each other's names; builds one by one have these warnings.
    target_compile_options(pie_warnings INTERFACE -Wno-shadow $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endif()
if(PIE_SANITIZE)
    target_compile_options(pie_warnings INTERFACE -fsanitize=${PIE_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
    if(PIE_SANITIZE MATCHES "address.*undefined")
        # A third of the compile time; the address sanitizer sees null pointers and objects that are gone without them.
        target_compile_options(pie_warnings INTERFACE -fno-sanitize=null,vptr)
    endif()
    target_link_options(pie_flags INTERFACE -fsanitize=${PIE_SANITIZE})
endif()

function(pie_module name)
    cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS;PUBLIC;PRIVATE" ${ARGN})
    add_library(pie_${name} STATIC ${ARG_SOURCES})
    add_library(pie::${name} ALIAS pie_${name})
    list(TRANSFORM ARG_DEPENDS PREPEND pie::)
    target_link_libraries(pie_${name} PUBLIC pie_flags ${ARG_DEPENDS} ${ARG_PUBLIC} PRIVATE $<BUILD_INTERFACE:pie_warnings> ${ARG_PRIVATE})
    target_include_directories(pie_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
    set_target_properties(pie_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON EXPORT_NAME ${name} CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
    set_property(GLOBAL APPEND PROPERTY PIE_MODULES pie_${name})
endfunction()
