#include "pie/level/file_source.h"
#include "pie/level/names.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <mutex>
#include <system_error>

namespace fs = std::filesystem;

namespace pie::level {
namespace {

/// How deep a listing descends: deeper than any game directory, and an end for links that lead back up.
constexpr int maxDepth = 16;

/// Looks names up as they are asked for: a level may stand in somebody's home, which nobody wants to scan.
class FolderSource final : public FileSource {
public:
    explicit FolderSource(fs::path root) : root_(std::move(root)) {}

    bool contains(const std::string& name) const override { return find(name).has_value(); }

    std::string origin(const std::string& name) const override {
        return (root_ / find(name).value_or(name)).lexically_normal().string();
    }

    Result<Bytes> read(const std::string& name) const override {
        const std::optional<std::string> real = find(name);
        if (!real) return Error{(root_ / name).string(), "", "no such file", ""};
        return readWholeFile(root_ / *real);
    }

    std::vector<std::string> list(const std::string& folder, const std::string& suffix) const override {
        std::vector<std::string> result;
        collect(folder, suffix, maxDepth, result);
        return result;
    }

private:
    struct Entry {
        std::string realName;
        bool folder = false;
    };
    using Listing = std::map<std::string, Entry, std::less<>>;

    /// Entries of one folder by their name in lower case; `folder` is "" or ends in '/'.
    const Listing& listing(const std::string& folder, const std::string& realFolder) const {
        const std::lock_guard lock(mutex_);
        const auto [found, isNew] = listings_.try_emplace(folder);
        if (isNew) scan(root_ / realFolder, found->second);
        return found->second;
    }

    static void scan(const fs::path& folder, Listing& into) {
        std::error_code ignored;
        for (fs::directory_iterator it(folder, ignored), end; !ignored && it != end; it.increment(ignored)) {
            // What the folder itself says of an entry; only links cost a look of their own.
            std::error_code error;
            const bool isFolder = it->is_directory(error);
            if (error || (!isFolder && !it->is_regular_file(error))) continue;
            Entry entry{it->path().filename().string(), isFolder};
            // Two names that differ in case only: which one the system lists first must not matter.
            const auto [known, isNew] = into.try_emplace(lower(entry.realName), entry);
            if (!isNew && entry.realName < known->second.realName) known->second = std::move(entry);
        }
    }

    std::optional<std::string> find(const std::string& name) const {
        std::string folder;
        std::string real;
        std::size_t begin = 0;
        for (;;) {
            const std::size_t slash = name.find('/', begin);
            const bool last = slash == std::string::npos;
            const Listing& entries = listing(folder, real);
            const auto entry = entries.find(std::string_view(name).substr(begin, last ? slash : slash - begin));
            if (entry == entries.end() || entry->second.folder == last) return std::nullopt;
            real += entry->second.realName;
            if (last) return real;
            folder = name.substr(0, slash + 1);
            real += '/';
            begin = slash + 1;
        }
    }

    std::optional<std::string> findFolder(const std::string& folder) const {
        std::string real;
        std::size_t begin = 0;
        while (begin < folder.size()) {
            const std::size_t slash = folder.find('/', begin);
            const Listing& entries = listing(folder.substr(0, begin), real);
            const auto entry = entries.find(std::string_view(folder).substr(begin, slash - begin));
            if (entry == entries.end() || !entry->second.folder) return std::nullopt;
            real += entry->second.realName + '/';
            begin = slash + 1;
        }
        return real;
    }

    void collect(const std::string& folder, const std::string& suffix, int depth,
                 std::vector<std::string>& into) const {
        const std::optional<std::string> real = findFolder(folder);
        if (!real || depth == 0) return;
        for (const auto& [name, entry] : listing(folder, *real)) {
            if (entry.folder)
                collect(folder + name + '/', suffix, depth - 1, into);
            else if (endsWithNoCase(name, suffix))
                into.push_back(folder + name);
        }
    }

    fs::path root_;
    mutable std::mutex mutex_;
    mutable std::map<std::string, Listing> listings_;
};

class MemorySource final : public FileSource {
public:
    MemorySource(std::string name, std::vector<std::pair<std::string, Bytes>>&& files) : name_(std::move(name)) {
        for (auto& [fileName, bytes] : files)
            if (std::optional<std::string> safe = safeName(fileName))
                files_.insert_or_assign(std::move(*safe), std::move(bytes));
    }
    bool contains(const std::string& name) const override { return files_.contains(name); }
    std::string origin(const std::string& name) const override { return name_ + "/" + name; }
    Result<Bytes> read(const std::string& name) const override {
        const auto found = files_.find(name);
        if (found == files_.end()) return Error{origin(name), "", "no such file", ""};
        return found->second;
    }
    std::vector<std::string> list(const std::string& folder, const std::string& suffix) const override {
        std::vector<std::string> result;
        for (const auto& [name, bytes] : files_)
            if (name.starts_with(folder) && endsWithNoCase(name, suffix)) result.push_back(name);
        return result;
    }

private:
    std::string name_;
    std::map<std::string, Bytes> files_;
};

} // namespace

Result<Bytes> readWholeFile(const fs::path& path) {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(path, error);
    if (error) return Error{path.string(), "", "cannot be read: " + error.message(), ""};
    if (size > maxFileBytes) return Error{path.string(), "", "is larger than 1 GiB", ""};
    std::ifstream stream;
    stream.rdbuf()->pubsetbuf(nullptr, 0); // read in one piece, straight to where it goes
    stream.open(path, std::ios::binary);
    Bytes bytes(size);
    // The stream's character type is char; looking at bytes through it is allowed.
    if (!stream || !stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size)))
        return Error{path.string(), "", "cannot be read", ""};
    return bytes;
}

std::shared_ptr<const FileSource> makeFolderSource(const fs::path& folder) {
    return std::make_shared<FolderSource>(folder);
}

std::shared_ptr<const FileSource> makeMemorySource(std::string name, std::vector<std::pair<std::string, Bytes>> files) {
    return std::make_shared<MemorySource>(std::move(name), std::move(files));
}

} // namespace pie::level
