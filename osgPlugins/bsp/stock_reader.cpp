#include "osgPlugins/bsp/stock_reader.h"

#include <osgDB/FileUtils>
#include <osgDB/Registry>

#include <dlfcn.h>

#include <algorithm>
#include <filesystem>
#include <mutex>

namespace osgpie_bsp {
namespace {

namespace fs = std::filesystem;

fs::path ownPath() {
    Dl_info info{};
    if (dladdr(reinterpret_cast<const void*>(&stockReader), &info) == 0 || !info.dli_fname) return {};
    std::error_code ignored;
    return fs::weakly_canonical(info.dli_fname, ignored);
}

/// Plug-in files of our name in OSG's folders, without ours and without other copies of it.
std::vector<std::string> candidates() {
    const fs::path own = ownPath();
    const std::string folder = own.parent_path().filename().string(); // osgPlugins-<version>
    std::vector<std::string> found;
    for (const std::string& path : osgDB::Registry::instance()->getLibraryFilePathList())
        for (const fs::path& file : {fs::path(path) / own.filename(), fs::path(path) / folder / own.filename()}) {
            std::error_code error;
            const fs::path real = fs::weakly_canonical(file, error);
            if (!error && fs::is_regular_file(real, error) && real != own) found.push_back(real.string());
        }
    return found;
}

} // namespace

osgDB::ReaderWriter* stockReader(std::string& reason) {
    static std::mutex mutex;
    const std::lock_guard lock(mutex);
    static osg::ref_ptr<osgDB::ReaderWriter> reader;
    osgDB::Registry* registry = osgDB::Registry::instance();
    for (const std::string& path : reader ? std::vector<std::string>{} : candidates()) {
        const auto before = registry->getReaderWriterList();
        if (registry->loadLibrary(path) == osgDB::Registry::NOT_LOADED) continue;
        for (const auto& added : registry->getReaderWriterList())
            if (std::find(before.begin(), before.end(), added) == before.end() && added->acceptsExtension("bsp") &&
                std::string(added->libraryName()) != "osgpie")
                reader = added;
        if (!reader) continue;
        // The registry asks every reader it knows until one answers: a damaged Quake 3 level would reach the stock
        // reader after us, which crashes on it or calls an empty scene a success.
        registry->removeReaderWriter(reader);
        break;
    }
    if (!reader)
        reason = "OpenSceneGraph's own bsp plug-in, which reads Valve levels, was not found beside its other plug-ins";
    return reader.get();
}

} // namespace osgpie_bsp
