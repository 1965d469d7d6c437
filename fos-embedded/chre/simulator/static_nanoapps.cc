// The list of nanoapps that are linked into the simulator: ours.

#include "chre/core/static_nanoapps.h"
#include "chre/platform/static_nanoapp_init.h"
#include "chre/util/macros.h"
#include "chre/util/system/napp_permissions.h"
#include "chre_api/chre/nanoapp.h"
#include "chre_api/chre/version.h"

#include "fos_nanoapp_messages.h"

CHRE_STATIC_NANOAPP_INIT(Fos, FOS_NANOAPP_ID, FOS_NANOAPP_VERSION, chre::NanoappPermissions::CHRE_PERMS_NONE)

namespace chre {

const StaticNanoappInitFunction kStaticNanoappList[] = {initializeStaticNanoappFos};
const size_t kStaticNanoappCount = ARRAY_SIZE(kStaticNanoappList);

} // namespace chre
