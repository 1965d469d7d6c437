// The link between CHRE and the host: messages go into files, and come from the script.

#include "host.h"

#include <algorithm>
#include <atomic>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "chre/core/event_loop_manager.h"
#include "chre/core/host_comms_manager.h"
#include "chre/platform/host_link.h"

#include "fos.h"
#include "fos_nanoapp_messages.h"

namespace fos {

namespace {

enum : uint16_t { ENDPOINT = 0x1234 };
enum { PART_HEADER = 8 };
enum : size_t { PART = 512 }; // bytes of a part where the script does not say

std::FILE *bias_file, *telemetry_file, *answer_file;
std::atomic<bool> busy;
unsigned long n_bias, n_telemetry, n_answers, n_wrong;

std::FILE *open_in(const char *folder, const char *name, const char *mode)
{
    std::FILE *file = std::fopen((std::string(folder) + "/" + name).c_str(), mode);
    if (file == nullptr) {
        std::fprintf(stderr, "%s/%s: cannot be written\n", folder, name);
        std::exit(1);
    }
    return file;
}

std::vector<uint8_t> bytes_of(const std::string &path)
{
    std::FILE *file = std::fopen(path.c_str(), "rb");
    if (file == nullptr) {
        std::fprintf(stderr, "%s: cannot be read\n", path.c_str());
        std::exit(1);
    }
    std::vector<uint8_t> bytes;
    for (int byte; (byte = std::fgetc(file)) != EOF;)
        bytes.push_back(static_cast<uint8_t>(byte));
    std::fclose(file);
    return bytes;
}

void send(uint32_t type, const std::vector<uint8_t> &bytes)
{
    chre::EventLoopManagerSingleton::get()->getHostCommsManager().sendMessageToNanoappFromHost(
        FOS_NANOAPP_ID, type, ENDPOINT, bytes.data(), bytes.size());
}

void send_model(const std::vector<uint8_t> &image, size_t part_bytes)
{
    for (size_t at = 0; at < image.size(); at += part_bytes) {
        size_t n = std::min(part_bytes, image.size() - at);
        std::vector<uint8_t> message(PART_HEADER + n);
        uint8_t *to = fos_message_put(message.data(), image.size(), 4);
        fos_message_put(to, at, 4);
        std::copy_n(image.begin() + static_cast<std::ptrdiff_t>(at), n, message.begin() + PART_HEADER);
        send(FOS_MESSAGE_MODEL, message);
    }
}

// One line of numbers. What must not be in them is counted.
bool take_bias(const uint8_t *bytes, size_t length)
{
    if (length != FOS_MESSAGE_BIAS_BYTES)
        return false;
    std::fprintf(bias_file, "%.9f", static_cast<double>(static_cast<int64_t>(fos_message_get(bytes, 8))) * 1e-9);
    bool finite = true;
    for (int axis = 0; axis < FOS_AXES; axis++) {
        float bias = fos_message_get_float(bytes + 8 + 4 * axis);
        finite = finite && std::isfinite(bias);
        std::fprintf(bias_file, ",%.9g", static_cast<double>(bias));
    }
    for (int axis = 0; axis < FOS_AXES; axis++)
        std::fprintf(bias_file, ",%" PRIu64, fos_message_get(bytes + 32 + 2 * axis, 2));
    std::fprintf(bias_file, ",%" PRIu64 ",%d,%d\n", fos_message_get(bytes + 44, 2), bytes[46], bytes[47]);
    return finite;
}

bool take_answer(const uint8_t *bytes, size_t length)
{
    if (length != FOS_MESSAGE_ANSWER_BYTES)
        return false;
    uint32_t numbers[FOS_MESSAGE_ANSWER_BYTES / 4];
    for (int k = 0; k < FOS_MESSAGE_ANSWER_BYTES / 4; k++)
        numbers[k] = static_cast<uint32_t>(fos_message_get(bytes + 4 * k, 4));
    int32_t status = static_cast<int32_t>(numbers[1]);
    std::fprintf(answer_file,
                 "command %03" PRIx32 ": %s; version %08" PRIx32 ", image %" PRIu32 " bytes %08" PRIx32
                 ", gyro every %" PRIu32 " ns, rows %" PRIu32 ", readings refused %" PRIu32
                 ", messages lost %" PRIu32 ", models taken %" PRIu32 ", refused %" PRIu32 ", sensors %" PRIx32 "\n",
                 numbers[0], fos_status_text(status), numbers[2], numbers[3], numbers[4], numbers[5], numbers[6],
                 numbers[7], numbers[8], numbers[9], numbers[10], numbers[11]);
    return true;
}

void take(uint32_t type, const uint8_t *bytes, size_t length)
{
    bool right = false;
    if (type == FOS_MESSAGE_BIAS) {
        n_bias++;
        right = take_bias(bytes, length);
    } else if (type == FOS_MESSAGE_ANSWER) {
        n_answers++;
        right = take_answer(bytes, length);
    } else if (type == FOS_MESSAGE_FRAMES) {
        n_telemetry++;
        // frames end with a zero, and are whole
        right = length > 0 && bytes[length - 1] == 0 && std::fwrite(bytes, 1, length, telemetry_file) == length;
    }
    if (!right)
        n_wrong++;
}

} // namespace

void open_host(const char *folder)
{
    bias_file = open_in(folder, "bias.csv", "w");
    telemetry_file = open_in(folder, "telemetry", "wb");
    answer_file = open_in(folder, "answers", "w");
    std::fputs("t_s,ax,ay,az,gx,gy,gz,validity_ax,validity_ay,validity_az,validity_gx,validity_gy,validity_gz,"
               "faults,still,drift\n",
               bias_file);
}

bool host_takes(const Step &step)
{
    auto word = [&step](size_t k) { return step.words[k]; };
    auto one_byte = [](int value) { return std::vector<uint8_t>{static_cast<uint8_t>(value)}; };
    if (step.what == "host") {
        busy = word(0) == "busy";
    } else if (step.what == "model") {
        size_t part = step.words.size() > 1 ? std::strtoul(word(1).c_str(), nullptr, 10) : PART;
        send_model(bytes_of(word(0)), std::max<size_t>(part, 1));
    } else if (step.what == "status") {
        send(FOS_MESSAGE_STATUS, {});
    } else if (step.what == "telemetry") {
        send(FOS_MESSAGE_TELEMETRY, one_byte(word(0) == "on" ? 1 : 0));
    } else if (step.what == "motion") {
        send(FOS_MESSAGE_MOTION, one_byte(word(0) == "detect"   ? FOS_MOTION_DETECT
                                          : word(0) == "moving" ? FOS_MOTION_MOVING
                                                                : FOS_MOTION_STILL));
    } else if (step.what == "message") {
        send(static_cast<uint32_t>(std::strtoul(word(0).c_str(), nullptr, 0)), bytes_of(word(1)));
    } else {
        return false;
    }
    return true;
}

void close_host()
{
    for (std::FILE *file : {bias_file, telemetry_file, answer_file}) {
        if (std::fclose(file) != 0)
            n_wrong++;
    }
    std::printf("host: %lu messages of bias, %lu of telemetry, %lu answers, %lu not as they should be\n", n_bias,
                n_telemetry, n_answers, n_wrong);
    if (n_wrong > 0)
        std::exit(1);
}

} // namespace fos

namespace chre {

void HostLink::flushMessagesSentByNanoapp(uint64_t /* app */) {} // none waits

bool HostLink::sendMessage(const MessageToHost *message)
{
    if (fos::busy)
        return false;
    fos::take(message->toHostData.messageType, message->message.data(), message->message.size());
    EventLoopManagerSingleton::get()->getHostCommsManager().onMessageToHostComplete(message);
    return true;
}

} // namespace chre
