# A variant of CHRE's simulator: a phone on a desk, its sensors play a log, its host and its only nanoapp are ours.
#
# Named by CHRE_VARIANT_MK_INCLUDES. FOS_CHRE is the folder above this one, FOS_ARCHIVE the static library of fos;
# both absolute.

CHRE_AUDIO_SUPPORT_ENABLED = false
CHRE_GNSS_SUPPORT_ENABLED = false
CHRE_SENSORS_SUPPORT_ENABLED = true
CHRE_WIFI_SUPPORT_ENABLED = false
CHRE_WWAN_SUPPORT_ENABLED = false

COMMON_CFLAGS += -DCHRE_VERSION_STRING='"fos"'
COMMON_CFLAGS += -DCHRE_VARIANT_SUPPLIES_STATIC_NANOAPP_LIST
COMMON_CFLAGS += -I$(FOS_CHRE) -I$(FOS_CHRE)/../include -Ichre_api/include/chre_api

COMMON_SRCS += $(FOS_CHRE)/fos_nanoapp.c
COMMON_SRCS += $(FOS_CHRE)/fos_nanoapp_host.c
COMMON_SRCS += $(FOS_CHRE)/fos_nanoapp_image.c
COMMON_SRCS += $(FOS_CHRE)/simulator/static_nanoapps.cc

GOOGLE_X86_LINUX_SRCS += $(FOS_CHRE)/simulator/main.cc
SIM_SRCS += $(FOS_CHRE)/simulator/host_link_file.cc
SIM_SRCS += $(FOS_CHRE)/simulator/log.cc
SIM_SRCS += $(FOS_CHRE)/simulator/pal_sensor_log.cc
SIM_SRCS += $(FOS_CHRE)/simulator/script.cc

GOOGLE_X86_LINUX_LATE_LIBS += $(FOS_ARCHIVE)
