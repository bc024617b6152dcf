#pragma once
// Says when a file has been saved. Watches the folders (inotify), as editors save by writing over the file, by renaming
// another over it, or by removing it and writing anew: after each a watch on the file itself would be deaf. Where the
// kernel has no watch to give, the files' times are looked at twice a second instead.

#include "pie/level/level.h"

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

namespace pieview {

class FileWatch {
public:
    /// Files need not be there yet; their folders must.
    explicit FileWatch(const std::vector<std::filesystem::path>& files);
    ~FileWatch();
    FileWatch(const FileWatch&) = delete;
    FileWatch& operator=(const FileWatch&) = delete;

    /// Watches these, too; those it knows are not watched twice.
    void add(const std::vector<std::filesystem::path>& files);
    /// Whether any was saved since the last call: written and closed, or put in its place whole. Does not wait.
    [[nodiscard]] bool changed();

private:
    struct Watched {
        std::filesystem::path file;
        int descriptor = -1; ///< of its folder; -1: none to be had
        std::filesystem::file_time_type time;
    };
    void attach(Watched& watched) const;
    [[nodiscard]] bool readEvents();
    [[nodiscard]] bool lookAtTimes();

    int inotify_ = -1;
    std::vector<Watched> files_;
    std::chrono::steady_clock::time_point nextLook_{};
};

/// What a level is read from: itself (or the archive it is in), where a link leads, and for a .bsp the .map beside it.
[[nodiscard]] std::vector<std::filesystem::path> filesOfLevel(const std::filesystem::path& level);

/// Pictures and shader scripts on disk that `level` was made with; what lies in archives is not among them.
[[nodiscard]] std::vector<std::filesystem::path> filesAround(const pie::level::Level& level);

} // namespace pieview
