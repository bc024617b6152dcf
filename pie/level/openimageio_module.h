#pragma once
// The door of pie_openimageio.so, which is loaded at the first picture that needs OpenImageIO. Looked for in the
// folders of PIE_MODULE_PATH (':' between them), beside the plug-in or program that pie is linked into (../pie,
// ../lib/pie), and where it is installed. Not for use outside pie/level.

#include "pie/level/decoders.h"

namespace pie::level {

/// Decodes, or with `size` only reads width and height. Never throws.
using OpenImageIoCall = void(std::span<const std::byte> bytes, const std::string& extension, Decoding& result,
                             std::optional<PictureSize>* size);

/// The name by which it is found, with C linkage. It ends in a number that grows when what is handed over changes.
inline constexpr const char* openImageIoSymbol = "pieOpenImageIo1";

} // namespace pie::level
