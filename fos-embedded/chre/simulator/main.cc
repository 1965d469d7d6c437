// libchre LOG RATE_HZ SCRIPT FOLDER [NANOAPP]: a phone's hub, its sensors played from LOG (CSV), set to RATE_HZ. What
// happens meanwhile is in SCRIPT, what the nanoapp sends goes into FOLDER. NANOAPP is one that was built apart, in place
// of the one in here.

#include <cstdio>
#include <cstdlib>
#include <future>
#include <thread>

#include "chre/core/event_loop.h"
#include "chre/core/event_loop_manager.h"
#include "chre/core/init.h"
#include "chre/core/static_nanoapps.h"
#include "chre/platform/linux/platform_log.h"

#include "fos_nanoapp_messages.h"
#include "host.h"
#include "player.h"

using chre::EventLoopManagerSingleton;
using chre::SystemCallbackType;

namespace {

const char *nanoapp_file;
std::promise<void> restarted;

void start_nanoapp()
{
    chre::UniquePtr<chre::Nanoapp> nanoapp;
    if (nanoapp_file == nullptr) {
        nanoapp = chre::kStaticNanoappList[0]();
    } else {
        nanoapp = chre::MakeUnique<chre::Nanoapp>();
        nanoapp->loadFromFile(nanoapp_file);
    }
    if (!EventLoopManagerSingleton::get()->getEventLoop().startNanoapp(nanoapp)) {
        std::fprintf(stderr, "the nanoapp does not start\n");
        std::exit(1);
    }
}

void restart_nanoapp(uint16_t, void *, void *)
{
    chre::EventLoop &loop = EventLoopManagerSingleton::get()->getEventLoop();
    uint32_t instance;
    if (loop.findNanoappInstanceIdByAppId(FOS_NANOAPP_ID, &instance))
        loop.unloadNanoapp(instance, true);
    start_nanoapp();
    restarted.set_value();
}

void in_the_loop(chre::SystemEventCallbackFunction *what)
{
    EventLoopManagerSingleton::get()->deferCallback(SystemCallbackType::FirstCallbackType, nullptr, what);
}

// Steps that are not the player's.
void take(const fos::Step &step)
{
    if (fos::host_takes(step))
        return;
    if (step.what == "restart") {
        // While no nanoapp runs, the player waits for nothing and a busy machine would play the log to its end.
        restarted = std::promise<void>();
        in_the_loop(restart_nanoapp);
        restarted.get_future().wait();
    }
}

void when_over() { EventLoopManagerSingleton::get()->getEventLoop().stop(); }

} // namespace

int main(int argc, char **argv)
{
    if (argc < 5 || argc > 6) {
        std::fprintf(stderr, "usage: libchre LOG RATE_HZ SCRIPT FOLDER [NANOAPP]\n");
        return 2;
    }
    nanoapp_file = argc > 5 ? argv[5] : nullptr;
    fos::Log log = fos::read_log(argv[1], std::strtod(argv[2], nullptr));
    fos::open_player(log, fos::read_script(argv[3]), take);
    fos::open_host(argv[4]);
    chre::PlatformLogSingleton::init();
    chre::init();
    std::thread loop([] {
        EventLoopManagerSingleton::get()->lateInit();
        start_nanoapp();
        in_the_loop([](uint16_t, void *, void *) { fos::start_player(when_over); });
        EventLoopManagerSingleton::get()->getEventLoop().run();
    });
    loop.join();
    fos::close_player();
    chre::deinit();
    chre::PlatformLogSingleton::deinit();
    fos::close_host();
    return 0;
}
