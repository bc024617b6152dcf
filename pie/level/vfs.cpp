#include "pie/level/vfs.h"
#include "pie/level/file_source.h"
#include "pie/level/names.h"

#include "pie/core/parallel.h"

#include <algorithm>
#include <system_error>
#include <unordered_set>

namespace fs = std::filesystem;

namespace pie::level {
namespace {

/// The game compares pk3 names in upper case, which sorts '_' after the letters.
std::string pakOrder(const fs::path& path) {
    std::string name = path.filename().string();
    for (char& c : name)
        if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    return name;
}

/// "" or a safe folder name with '/' behind it; nothing if the name climbs out.
std::optional<std::string> folderPrefix(std::string_view folder) {
    if (folder.empty() || folder == "/" || folder == ".") return std::string();
    std::optional<std::string> safe = safeName(folder);
    if (safe) *safe += '/';
    return safe;
}

} // namespace

Result<bool> Vfs::mountFolder(const fs::path& folder) {
    std::error_code error;
    if (!fs::is_directory(folder, error)) return Error{folder.string(), "", "is not a folder", ""};
    sources_.push_back(makeFolderSource(folder));
    return true;
}

Result<bool> Vfs::mountArchive(const fs::path& pk3) {
    Result<std::shared_ptr<const FileSource>> source = makeArchiveSource(pk3);
    if (!source) return source.error();
    sources_.push_back(std::move(*source));
    return true;
}

void Vfs::mountMemory(std::string name, std::vector<std::pair<std::string, Bytes>> files) {
    sources_.push_back(makeMemorySource(std::move(name), std::move(files)));
}

Result<bool> Vfs::mountGame(const fs::path& gameDirectory) {
    std::error_code error;
    if (!fs::is_directory(gameDirectory, error))
        return Error{gameDirectory.string(), "", "is not a game directory (no such folder)", ""};
    std::vector<fs::path> paks;
    for (fs::directory_iterator it(gameDirectory, error), end; !error && it != end; it.increment(error)) {
        const std::string name = it->path().filename().string();
        if (endsWithNoCase(name, ".pk3") || endsWithNoCase(name, ".pk3dir")) paks.push_back(it->path());
    }
    std::sort(paks.begin(), paks.end(), [](const fs::path& a, const fs::path& b) {
        return std::pair(pakOrder(a), a.string()) < std::pair(pakOrder(b), b.string());
    });
    // Reading the directories of big archives takes longer than anything else that mounting does.
    std::vector<std::optional<Result<std::shared_ptr<const FileSource>>>> opened(paks.size());
    parallelChunks(paks.size(), 1, [&](std::size_t i, std::size_t) {
        std::error_code ignored;
        if (fs::is_directory(paks[i], ignored))
            opened[i] = makeFolderSource(paks[i]);
        else
            opened[i] = makeArchiveSource(paks[i]);
    });
    for (const auto& source : opened) {
        if (*source)
            sources_.push_back(**source);
        else
            warnings_.push_back(source->error().message());
    }
    return mountFolder(gameDirectory);
}

bool Vfs::contains(std::string_view name) const {
    const std::optional<std::string> safe = safeName(name);
    return safe && std::any_of(sources_.begin(), sources_.end(), [&](const auto& s) { return s->contains(*safe); });
}

std::string Vfs::origin(std::string_view name) const {
    if (const std::optional<std::string> safe = safeName(name))
        for (std::size_t i = sources_.size(); i-- > 0;)
            if (sources_[i]->contains(*safe)) return sources_[i]->origin(*safe);
    return {};
}

Result<Bytes> Vfs::read(std::string_view name) const {
    const std::optional<std::string> safe = safeName(name);
    if (!safe) return Error{std::string(name), "", "is not a name inside a game directory", ""};
    for (std::size_t i = sources_.size(); i-- > 0;)
        if (sources_[i]->contains(*safe)) return sources_[i]->read(*safe);
    return Error{std::string(name), "", "no such file in the folders and pk3 files of the level", ""};
}

std::vector<std::string> Vfs::list(std::string_view folder, std::string_view suffix) const {
    std::vector<std::string> names = scan(folder, suffix);
    std::sort(names.begin(), names.end());
    return names;
}

std::vector<std::string> Vfs::scan(std::string_view folder, std::string_view suffix) const {
    std::vector<std::string> result;
    const std::optional<std::string> prefix = folderPrefix(folder);
    if (!prefix) return result;
    std::unordered_set<std::string> seen;
    for (std::size_t i = sources_.size(); i-- > 0;)
        for (std::string& name : sources_[i]->list(*prefix, std::string(suffix)))
            if (seen.insert(name).second) result.push_back(std::move(name));
    return result;
}

} // namespace pie::level
