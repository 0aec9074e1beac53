#include "host_sim/lab/toml_reader.h"
#include "host_sim/lab/inputs.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>
#include <vector>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

/* toml++ 3.3 asserts things that a broken file can break ("[.]"), and with NDEBUG assumes them. Here it is an
 * exception. */
struct toml_defect_t {
};
static constexpr void toml_demand(bool holds)
{
    if (!holds) {
        throw toml_defect_t();
    }
}
#undef NDEBUG
#define TOML_ASSERT(expression) toml_demand(static_cast<bool>(expression))
#define TOML_EXCEPTIONS         0
#include <toml++/toml.h>

namespace
{

/* Objects that a C struct cannot own while the list still grows. */
struct draft_t {
    toml_entry_t entry;
    std::string key, path, text;
};

/* A longer path is useless in a message, and a tree of long paths would fill the memory. */
constexpr size_t path_max = 200;

struct place_t {
    uint32_t line, column;
};

place_t place_of(const toml::source_region &region)
{
    return {static_cast<uint32_t>(region.begin.line), static_cast<uint32_t>(region.begin.column)};
}

bool before(const place_t &a, const place_t &b)
{
    return a.line != b.line ? a.line < b.line : a.column < b.column;
}

toml_type_t type_of(const toml::node &node)
{
    switch (node.type()) {
    case toml::node_type::table:
        return TOML_TABLE;
    case toml::node_type::array:
        return TOML_ARRAY;
    case toml::node_type::string:
        return TOML_TEXT;
    case toml::node_type::integer:
        return TOML_INTEGER;
    case toml::node_type::floating_point:
        return TOML_FLOAT;
    case toml::node_type::boolean:
        return TOML_BOOL;
    default:
        return TOML_TIME;
    }
}

void add(std::vector<draft_t> &list, const toml::node &node, const std::string &key, const std::string &path,
         place_t place, uint32_t parent);

void add_children(std::vector<draft_t> &list, const toml::table &table, const std::string &path,
                  uint32_t parent)
{
    struct child_t {
        const toml::key *key;
        const toml::node *node;
        place_t place;
    };
    std::vector<child_t> children;
    for (auto &&[key, node] : table) {
        children.push_back({&key, &node, place_of(key.source())});
    }
    std::stable_sort(children.begin(), children.end(),
                     [](const child_t &a, const child_t &b) { return before(a.place, b.place); });
    for (const child_t &child : children) {
        std::string name(child.key->str());
        std::replace(name.begin(), name.end(), '\0',
                     '?'); /* no accepted key, and a C string would end at this character */
        add(list, *child.node, name, path.empty() ? name : path + "." + name, child.place, parent);
    }
}

/* Depth is limited by is_readable(). */
void add(std::vector<draft_t> &list, const toml::node &node, const std::string &key,
         const std::string &full_path, place_t place, uint32_t parent)
{
    const std::string path = full_path.substr(0, path_max);
    const auto self = static_cast<uint32_t>(list.size());
    draft_t draft{};
    draft.key = key;
    draft.path = path;
    draft.entry.type = type_of(node);
    draft.entry.parent = parent;
    draft.entry.line = place.line;
    draft.entry.column = place.column;
    if (const auto *text = node.as_string()) {
        draft.text = text->get();
        draft.entry.text_octets = text->get().size();
    } else if (const auto *integer = node.as_integer()) {
        draft.entry.integer = integer->get();
        draft.entry.number = static_cast<double>(integer->get());
    } else if (const auto *number = node.as_floating_point()) {
        draft.entry.number = number->get();
    } else if (const auto *truth = node.as_boolean()) {
        draft.entry.integer = truth->get() ? 1 : 0;
    }
    list.push_back(std::move(draft));

    if (const auto *table = node.as_table()) {
        add_children(list, *table, path, self);
    } else if (const auto *array = node.as_array()) {
        size_t n = 0;
        for (const toml::node &element : *array) {
            add(list, element, "", path + "[" + std::to_string(n++) + "]", place_of(element.source()), self);
        }
    }
    list[self].entry.end = static_cast<uint32_t>(list.size());
}

char *copy_of(const char *text, size_t octets)
{
    auto *copy = static_cast<char *>(std::malloc(octets + 1u));
    if (copy == nullptr) {
        throw std::bad_alloc();
    }
    std::memcpy(copy, text, octets);
    copy[octets] = '\0';
    return copy;
}

char *copy_of(const std::string &text)
{
    return copy_of(text.data(), text.size());
}

toml_file_t *file_of(const std::vector<draft_t> &list, const char *text, size_t octets)
{
    auto *file = static_cast<toml_file_t *>(std::calloc(1, sizeof(toml_file_t)));
    if (file == nullptr) {
        throw std::bad_alloc();
    }
    try {
        file->entries = static_cast<toml_entry_t *>(std::calloc(list.size(), sizeof(toml_entry_t)));
        if (file->entries == nullptr) {
            throw std::bad_alloc();
        }
        for (const draft_t &draft : list) {
            toml_entry_t &entry = file->entries[file->count++];
            entry = draft.entry;
            entry.key = copy_of(draft.key);
            entry.path = copy_of(draft.path);
            entry.text = copy_of(draft.text);
        }
        file->source = copy_of(text, octets);
        file->octets = octets;
    } catch (...) {
        toml_free(file);
        throw;
    }
    return file;
}

void say(toml_error_t *error, place_t place, const std::string &name, const std::string &message)
{
    error->line = place.line;
    error->column = place.column;
    std::snprintf(error->name, sizeof error->name, "%s", name.c_str());
    std::snprintf(error->message, sizeof error->message, "%s", message.c_str());
    /* one line for any quoted text */
    for (char *c = error->message; *c != '\0'; c++) {
        *c = static_cast<unsigned char>(*c) < 0x20u || *c == 0x7F ? ' ' : *c;
    }
}

struct key_t {
    std::string name;
    uint32_t column; /* [1..] */
};

/* The key that a line of source begins with, if it has the form of a key. */
key_t key_on_line(const char *text, size_t octets, uint32_t line)
{
    const char *at = text;
    const char *const end = text + octets;
    for (uint32_t n = 1; n < line && at != end; n++) {
        at = std::find(at, end, '\n');
        at += at != end ? 1 : 0;
    }
    const char *const begin = std::find_if(at, end, [](char c) { return c != ' ' && c != '\t' && c != '['; });
    const char *const stop = std::find_if_not(begin, end, [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
               c == '-' || c == '.';
    });
    const auto length = std::min<size_t>(static_cast<size_t>(stop - begin), 60u);
    return {length == 0 || *begin == '.' ? "TOML" : std::string(begin, length),
            static_cast<uint32_t>(begin - at) + 1u};
}

/* toml++ limits the nesting of brackets, but not the number of tables that a dotted key makes, and frees all
 * of them by recursion. No reasonable file reaches these limits. Their product limits the depth of the tree.
 */
constexpr uint32_t brackets_max = 16u;
constexpr uint32_t dots_max = 64u; /* in one line, outside of texts and comments */

/* Walks over texts and comments as TOML has them. */
struct scanner_t {
    const char *at;
    const char *const end;
    place_t place = {1u, 1u};

    bool looking_at(const char *what) const
    {
        const size_t length = std::strlen(what);
        return static_cast<size_t>(end - at) >= length && std::memcmp(at, what, length) == 0;
    }
    void step(size_t octets)
    {
        for (; octets > 0 && at != end; octets--, at++) {
            place.column += (static_cast<unsigned char>(*at) & 0xC0u) != 0x80u ? 1u : 0u; /* code points */
            if (*at == '\n') {
                place = {place.line + 1u, 1u};
            }
        }
    }
    void skip_text(const char *quote, bool escapes, bool lines)
    {
        step(std::strlen(quote));
        while (at != end && !looking_at(quote) && (lines || *at != '\n')) {
            step(escapes && *at == '\\' ? 2u : 1u);
        }
        step(at != end && *at != '\n' ? std::strlen(quote) : 0u);
    }
};

/* Checks that toml++ does not do reliably; false: the reason has been printed. Text that is no TOML at all
 * is reported by the library. */
bool is_readable(const char *text, size_t octets, toml_error_t *error)
{
    scanner_t scanner{text, text + octets};
    uint32_t brackets = 0;
    uint32_t dots = 0;
    scanner.at += scanner.looking_at("\xEF\xBB\xBF") ? 3 : 0; /* byte order mark */
    while (scanner.at != scanner.end) {
        const char c = *scanner.at;
        if (scanner.looking_at("\"\"\"")) {
            scanner.skip_text("\"\"\"", true, true);
        } else if (scanner.looking_at("'''")) {
            scanner.skip_text("'''", false, true);
        } else if (c == '"' || c == '\'') {
            scanner.skip_text(c == '"' ? "\"" : "'", c == '"', false);
        } else if (static_cast<unsigned char>(c) >= 0x80u) {
            /* this is no TOML 1.0, and in some cases toml++ 3.3 has undefined behaviour */
            say(error, scanner.place, key_on_line(text, octets, scanner.place.line).name,
                "not TOML: a character outside of ASCII; accepted only in text and comments");
            return false;
        } else if (c == '#') {
            const auto *newline = std::find(scanner.at, scanner.end, '\n');
            scanner.step(static_cast<size_t>(newline - scanner.at));
        } else {
            brackets += c == '[' || c == '{' ? 1u : 0u;
            brackets -= (c == ']' || c == '}') && brackets > 0u ? 1u : 0u;
            dots = c == '\n' ? 0u : dots + (c == '.' ? 1u : 0u);
            if (brackets > brackets_max || dots > dots_max) {
                say(error, scanner.place, key_on_line(text, octets, scanner.place.line).name,
                    "nested too deeply; accepted: up to " + std::to_string(brackets_max) +
                        " brackets in each other and " + std::to_string(dots_max) + " dots in a line");
                return false;
            }
            scanner.step(1u);
        }
    }
    return true;
}

/* True if toml++ fails on this text. */
bool trips(const char *text, size_t octets)
{
    try {
        (void)toml::parse(std::string_view(text, octets));
    } catch (const toml_defect_t &) {
        return true;
    }
    return false;
}

/* The place of the failure: the last octet of the shortest beginning of the text on which it fails. */
void say_trip(const char *text, size_t octets, toml_error_t *error)
{
    size_t good = 0;
    for (size_t bad = octets; bad - good > 1u;) {
        const size_t middle = good + (bad - good) / 2u;
        if (trips(text, middle)) {
            bad = middle;
        } else {
            good = middle;
        }
    }
    scanner_t scanner{text, text + octets};
    scanner.step(good);
    say(error, scanner.place, key_on_line(text, octets, scanner.place.line).name,
        "not TOML: something else is expected here");
}

toml_file_t *parse(const char *text, size_t octets, toml_error_t *error)
{
    if (!is_readable(text, octets, error)) {
        return nullptr;
    }
    toml::parse_result result = toml::parse(std::string_view(text, octets));
    if (!result) {
        const toml::parse_error &why = result.error();
        place_t place = place_of(why.source());
        const key_t key = key_on_line(text, octets, place.line);
        if (why.description().find("redefine") != std::string_view::npos) {
            place.column = key.column; /* position of the duplicate key, not of the place where it was
                                        * detected */
        }
        const bool no_quotes =
            why.description().find("expected a comment or whitespace") != std::string_view::npos;
        say(error, place, key.name,
            "not TOML: " + std::string(why.description()) +
                (no_quotes ? "; a value with a unit is a text in quotes, \"1.5 s\"" : ""));
        return nullptr;
    }
    std::vector<draft_t> list;
    add(list, result.table(), "", "", {1u, 1u}, 0u);
    return file_of(list, text, octets);
}

/* The whole file; false: the reason has been printed. */
bool load(const char *path, std::vector<char> &content, toml_error_t *error)
{
    const place_t nowhere = {0u, 0u};
    /* Reading a pipe or a device might never end. */
    const int descriptor = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    struct stat kind {
    };
    if (descriptor < 0 || fstat(descriptor, &kind) != 0) {
        say(error, nowhere, TOML_WHOLE_FILE, std::string("it cannot be read: ") + std::strerror(errno));
        if (descriptor >= 0) {
            close(descriptor);
        }
        return false;
    }
    std::FILE *file = S_ISREG(kind.st_mode) ? fdopen(descriptor, "rb") : nullptr;
    if (file == nullptr) {
        close(descriptor);
        say(error, nowhere, TOML_WHOLE_FILE,
            std::string("it cannot be read, because it is ") +
                (S_ISDIR(kind.st_mode) ? "a directory" : "not a plain file"));
        return false;
    }
    try {
        content.resize(TOML_OCTETS_MAX + 1u);
        content.resize(std::fread(content.data(), 1, content.size(), file));
    } catch (...) {
        std::fclose(file);
        throw;
    }
    const bool good = std::ferror(file) == 0;
    std::fclose(file);
    if (!good) {
        say(error, nowhere, TOML_WHOLE_FILE, "it cannot be read to its end");
        return false;
    }
    return true;
}

toml_file_t *guarded(const char *path, const char *text, size_t octets, toml_error_t *error)
{
    try {
        std::vector<char> content;
        if (path != nullptr) {
            if (!load(path, content, error)) {
                return nullptr;
            }
            text = content.data();
            octets = content.size();
        }
        if (octets > TOML_OCTETS_MAX) {
            say(error, {0u, 0u}, TOML_WHOLE_FILE,
                "it is too large; accepted: up to " + std::to_string(TOML_OCTETS_MAX) + " octets");
            return nullptr;
        }
        try {
            return parse(text, octets, error);
        } catch (const toml_defect_t &) {
            say_trip(text, octets, error);
            return nullptr;
        }
    } catch (const std::exception &) {
        std::snprintf(error->name, sizeof error->name, TOML_WHOLE_FILE);
        std::snprintf(error->message, sizeof error->message, "there is not enough memory to read it");
        error->line = 0;
        error->column = 0;
        return nullptr;
    }
}

} // namespace

extern "C" {

toml_file_t *toml_read(const char *path, toml_error_t *error)
{
    inputs_note(path);
    return guarded(path, nullptr, 0, error);
}

toml_file_t *toml_read_text(const char *text, size_t octets, toml_error_t *error)
{
    return guarded(nullptr, text, octets, error);
}

void toml_free(toml_file_t *file)
{
    if (file == nullptr) {
        return;
    }
    for (uint32_t n = 0; n < file->count; n++) {
        std::free(const_cast<char *>(file->entries[n].key));
        std::free(const_cast<char *>(file->entries[n].path));
        std::free(const_cast<char *>(file->entries[n].text));
    }
    std::free(file->entries);
    std::free(file->source);
    std::free(file);
}

const char *toml_type_text(toml_type_t type)
{
    switch (type) {
    case TOML_TABLE:
        return "a table";
    case TOML_ARRAY:
        return "an array";
    case TOML_TEXT:
        return "text";
    case TOML_INTEGER:
        return "a whole number";
    case TOML_FLOAT:
        return "a number";
    case TOML_BOOL:
        return "a bool";
    case TOML_TIME:
        break;
    }
    return "a date or time";
}
}
