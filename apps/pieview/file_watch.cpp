#include "apps/pieview/file_watch.h"

#include <sys/inotify.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <cstring>

namespace pieview {

namespace fs = std::filesystem;

namespace {

fs::file_time_type timeOf(const fs::path& file) {
    std::error_code error;
    const auto time = fs::last_write_time(file, error);
    return error ? fs::file_time_type::min() : time;
}

fs::path folderOf(const fs::path& file) { return file.has_parent_path() ? file.parent_path() : fs::path("."); }

} // namespace

FileWatch::FileWatch(const std::vector<fs::path>& files) : inotify_(inotify_init1(IN_NONBLOCK | IN_CLOEXEC)) {
    add(files);
}

FileWatch::~FileWatch() {
    if (inotify_ >= 0) ::close(inotify_);
}

void FileWatch::add(const std::vector<fs::path>& files) {
    for (const fs::path& file : files) {
        if (std::any_of(files_.begin(), files_.end(), [&](const Watched& known) { return known.file == file; }))
            continue;
        Watched watched{file, -1, timeOf(file)};
        attach(watched);
        files_.push_back(std::move(watched));
    }
}

void FileWatch::attach(Watched& watched) const {
    if (inotify_ < 0) return;
    watched.descriptor =
        inotify_add_watch(inotify_, folderOf(watched.file).c_str(), IN_CLOSE_WRITE | IN_MOVED_TO | IN_ONLYDIR);
}

bool FileWatch::changed() {
    const bool told = readEvents();
    return lookAtTimes() || told;
}

bool FileWatch::readEvents() {
    if (inotify_ < 0) return false;
    bool saved = false;
    alignas(inotify_event) std::array<char, 16'384> buffer{};
    for (;;) {
        const ssize_t count = ::read(inotify_, buffer.data(), buffer.size());
        if (count <= 0) return saved;
        for (std::size_t at = 0; at + sizeof(inotify_event) <= static_cast<std::size_t>(count);) {
            inotify_event event{};
            std::memcpy(&event, buffer.data() + at, sizeof(event));
            const char* name = buffer.data() + at + sizeof(event);
            at += sizeof(event) + event.len;
            // Events were lost: one of them may have been ours.
            if ((event.mask & IN_Q_OVERFLOW) != 0) saved = true;
            for (Watched& watched : files_) {
                if (watched.descriptor != event.wd) continue;
                // The folder is gone; another may come in its place.
                if ((event.mask & IN_IGNORED) != 0) watched.descriptor = -1;
                if (event.len == 0 || watched.file.filename() != fs::path(name)) continue;
                saved = true;
                watched.time = timeOf(watched.file);
            }
        }
    }
}

bool FileWatch::lookAtTimes() {
    const auto now = std::chrono::steady_clock::now();
    if (now < nextLook_) return false;
    nextLook_ = now + std::chrono::milliseconds(500);
    bool saved = false;
    for (Watched& watched : files_) {
        if (watched.descriptor >= 0) continue;
        attach(watched);
        const auto time = timeOf(watched.file);
        if (time == fs::file_time_type::min() || time == watched.time) continue;
        watched.time = time;
        saved = true;
    }
    return saved;
}

std::vector<fs::path> filesOfLevel(const fs::path& level) {
    std::error_code error;
    std::vector<fs::path> files;
    // "some.pk3/maps/x.bsp": the archive is the file.
    fs::path file = level;
    for (fs::path above = level; above.has_relative_path(); above = above.parent_path())
        if (fs::is_regular_file(above, error)) {
            file = above;
            break;
        }
    files.push_back(file);
    const fs::path real = fs::canonical(file, error);
    if (!error && fs::is_symlink(file, error)) files.push_back(real);
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension == ".bsp") files.push_back(fs::path(file).replace_extension(".map"));
    return files;
}

std::vector<fs::path> filesAround(const pie::level::Level& level) {
    std::vector<fs::path> files;
    if (!level.files) return files;
    const auto add = [&](const std::string& name) {
        std::error_code error;
        const fs::path file = level.files->origin(name);
        if (!file.empty() && fs::is_regular_file(file, error)) files.push_back(file);
    };
    for (const auto& texture : level.textures)
        if (!texture.path.empty()) add(texture.path);
    for (const std::string& script : level.files->list("scripts", ".shader")) add(script);
    return files;
}

} // namespace pieview
