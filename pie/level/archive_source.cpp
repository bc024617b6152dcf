#include "pie/level/file_source.h"
#include "pie/level/names.h"

#include <zip.h>

#include <mutex>
#include <unordered_map>

namespace pie::level {
namespace {

struct ZipDiscard {
    void operator()(zip_t* archive) const { zip_discard(archive); }
};
using Zip = std::unique_ptr<zip_t, ZipDiscard>;

struct ZipFileClose {
    void operator()(zip_file_t* file) const { zip_fclose(file); }
};
using ZipFile = std::unique_ptr<zip_file_t, ZipFileClose>;

Result<Zip> openZip(const std::string& path) {
    int code = 0;
    if (zip_t* archive = zip_open(path.c_str(), ZIP_RDONLY, &code)) return Zip(archive);
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    const std::string reason = zip_error_strerror(&error);
    zip_error_fini(&error);
    return Error{path, "", "is not a readable pk3 (zip) archive: " + reason, ""};
}

/// A libzip handle serves one thread at a time. Reading pictures is where loading spends its time, so every thread that
/// reads borrows a handle of its own; handles are opened as they are needed and kept.
class ArchiveSource final : public FileSource {
public:
    ArchiveSource(std::string path, Zip first) : path_(std::move(path)) {
        const zip_int64_t count = zip_get_num_entries(first.get(), 0);
        names_.reserve(static_cast<std::size_t>(count));
        index_.reserve(static_cast<std::size_t>(count));
        for (zip_uint64_t i = 0; i < static_cast<zip_uint64_t>(count); ++i)
            addEntry(zip_get_name(first.get(), i, ZIP_FL_ENC_RAW), i);
        idle_.push_back(std::move(first));
    }

    bool contains(const std::string& name) const override { return index_.contains(name); }
    std::string origin(const std::string& name) const override { return path_ + "/" + name; }

    Result<Bytes> read(const std::string& name) const override {
        const auto found = index_.find(name);
        if (found == index_.end()) return Error{origin(name), "", "no such file", ""};
        Result<Zip> archive = borrow();
        if (!archive) return archive.error();
        Result<Bytes> bytes = readEntry(archive->get(), found->second, name);
        const std::lock_guard lock(mutex_);
        idle_.push_back(std::move(*archive));
        return bytes;
    }

    std::vector<std::string> list(const std::string& folder, const std::string& suffix) const override {
        std::vector<std::string> result;
        for (const std::string& name : names_)
            if (name.starts_with(folder) && endsWithNoCase(name, suffix)) result.push_back(name);
        return result;
    }

private:
    void addEntry(const char* rawName, zip_uint64_t entry) {
        if (rawName == nullptr) return;
        const std::string_view name = rawName;
        if (name.ends_with('/') || name.ends_with('\\')) return;
        std::optional<std::string> safe = safeName(name);
        if (!safe) return;
        // Of two entries of one name the game finds the later one.
        if (index_.insert_or_assign(*safe, entry).second) names_.push_back(std::move(*safe));
    }

    Result<Zip> borrow() const {
        {
            const std::lock_guard lock(mutex_);
            if (!idle_.empty()) {
                Zip archive = std::move(idle_.back());
                idle_.pop_back();
                return archive;
            }
        }
        return openZip(path_);
    }

    Result<Bytes> readEntry(zip_t* archive, zip_uint64_t entry, const std::string& name) const {
        const auto failed = [&](const std::string& why) {
            return Error{origin(name), "", "cannot be read from the archive: " + why, ""};
        };
        zip_stat_t stat;
        if (zip_stat_index(archive, entry, 0, &stat) != 0 || (stat.valid & ZIP_STAT_SIZE) == 0)
            return failed(zip_strerror(archive));
        if (stat.size > maxFileBytes) return failed("larger than 1 GiB");
        const ZipFile file(zip_fopen_index(archive, entry, 0));
        if (!file) return failed(zip_strerror(archive));
        // One byte more than the entry should have: reaching its end is what makes libzip check the checksum.
        Bytes bytes(stat.size + 1);
        std::size_t filled = 0;
        while (filled < bytes.size()) {
            const zip_int64_t got = zip_fread(file.get(), bytes.data() + filled, bytes.size() - filled);
            if (got < 0) return failed(zip_file_strerror(file.get()));
            if (got == 0) break;
            filled += static_cast<std::size_t>(got);
        }
        if (filled != stat.size) return failed("its length differs from the directory's");
        bytes.resize(filled);
        return bytes;
    }

    std::string path_;
    std::vector<std::string> names_;
    std::unordered_map<std::string, zip_uint64_t> index_;
    mutable std::mutex mutex_;
    mutable std::vector<Zip> idle_;
};

} // namespace

Result<std::shared_ptr<const FileSource>> makeArchiveSource(const std::filesystem::path& pk3) {
    Result<Zip> archive = openZip(pk3.string());
    if (!archive) return archive.error();
    return std::shared_ptr<const FileSource>(std::make_shared<ArchiveSource>(pk3.string(), std::move(*archive)));
}

} // namespace pie::level
