#include "pie/level/openimageio_module.h"

#include <dlfcn.h>

#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <vector>

namespace fs = std::filesystem;

namespace pie::level {
namespace {

constexpr const char* moduleFile = "pie_openimageio.so";

/// Folder of the plug-in or program that this code has been linked into.
fs::path ownFolder() {
    std::error_code error;
    Dl_info info{};
    fs::path self;
    if (dladdr(reinterpret_cast<const void*>(&ownFolder), &info) != 0 && info.dli_fname != nullptr)
        self = fs::canonical(info.dli_fname, error);
    // A program that was found through PATH knows itself by its bare name.
    if (self.empty() || error) self = fs::canonical("/proc/self/exe", error);
    return self.parent_path();
}

std::vector<fs::path> folders() {
    std::vector<fs::path> result;
    if (const char* listed = std::getenv("PIE_MODULE_PATH")) {
        for (std::string_view rest = listed; !rest.empty();) {
            const std::size_t end = std::min(rest.find(':'), rest.size());
            if (end > 0) result.emplace_back(rest.substr(0, end));
            rest.remove_prefix(std::min(end + 1, rest.size()));
        }
    }
    const fs::path own = ownFolder();
    result.insert(result.end(), {own / "../pie", own / "../lib/pie", PIE_MODULE_FOLDER});
    return result;
}

struct Module {
    OpenImageIoCall* call = nullptr;
    std::string failure;

    Module() {
        std::error_code error;
        for (const fs::path& folder : folders()) {
            const fs::path file = folder / moduleFile;
            if (!fs::exists(file, error)) continue;
            // Never closed: OpenImageIO keeps threads and tables.
            void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
            if (library != nullptr) call = reinterpret_cast<OpenImageIoCall*>(dlsym(library, openImageIoSymbol));
            if (call != nullptr) return;
            const char* why = dlerror();
            failure = why != nullptr ? why : file.string() + " is of another version";
        }
        if (failure.empty()) failure = std::string("this kind needs ") + moduleFile + ", which is not installed";
    }
};

const Module& module() {
    static const Module loaded;
    return loaded;
}

} // namespace

Decoding decodeOther(std::span<const std::byte> bytes, const std::string& extension) {
    Decoding result;
    if (module().call == nullptr)
        result.failure = module().failure;
    else
        module().call(bytes, extension, result, nullptr);
    return result;
}

std::optional<PictureSize> otherSize(std::span<const std::byte> bytes, const std::string& extension) {
    std::optional<PictureSize> size;
    Decoding ignored;
    if (module().call != nullptr) module().call(bytes, extension, ignored, &size);
    return size;
}

} // namespace pie::level
