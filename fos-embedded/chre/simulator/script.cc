#include "script.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace fos {

namespace {

struct Known {
    const char *what;
    size_t fewest, most;
};

const Known KNOWN[] = {
    {"missing", 1, 1}, {"rate", 2, 2},  {"lose", 2, 2},    {"order", 1, 1}, {"flood", 1, 1},
    {"spoil", 1, 1},   {"empty", 1, 1}, {"host", 1, 1},    {"restart", 0, 0}, {"model", 1, 2},
    {"status", 0, 0},  {"telemetry", 1, 1}, {"motion", 1, 1}, {"message", 2, 2},
};

bool is_known(const Step &step)
{
    for (const Known &known : KNOWN) {
        if (step.what == known.what)
            return step.words.size() >= known.fewest && step.words.size() <= known.most;
    }
    return false;
}

} // namespace

std::vector<Step> read_script(const char *path)
{
    std::FILE *file = std::fopen(path, "r");
    if (file == nullptr) {
        std::fprintf(stderr, "%s: cannot be opened\n", path);
        std::exit(1);
    }
    std::vector<Step> steps;
    char line[1024];
    for (unsigned long at = 1; std::fgets(line, sizeof line, file) != nullptr; at++) {
        line[std::strcspn(line, "#\r\n")] = '\0';
        std::vector<std::string> words;
        for (char *word = std::strtok(line, " \t"); word != nullptr; word = std::strtok(nullptr, " \t"))
            words.push_back(word);
        if (words.empty())
            continue;
        char *end = nullptr;
        double second = std::strtod(words[0].c_str(), &end);
        Step step;
        if (*end == '\0' && std::isfinite(second) && words.size() > 1) {
            step.after_ns = std::llround(second * 1e9);
            step.what = words[1];
            step.words.assign(words.begin() + 2, words.end());
        }
        if (!is_known(step)) {
            std::fprintf(stderr, "%s, line %lu: not a step: SECOND WHAT WORD...\n", path, at);
            std::exit(1);
        }
        steps.push_back(step);
    }
    std::fclose(file);
    std::stable_sort(steps.begin(), steps.end(),
                     [](const Step &a, const Step &b) { return a.after_ns < b.after_ns; });
    return steps;
}

} // namespace fos
