# What of CHRE's simulator the files beside this one take the place of.
#
# Named by CHRE_TARGET_EXTENSION, which is read when all source files are listed and before any is compiled.

SIM_SRCS := $(filter-out platform/linux/host_link.cc platform/shared/pal_sensor_stub.cc, $(SIM_SRCS))
GOOGLE_X86_LINUX_SRCS := $(filter-out platform/linux/init.cc, $(GOOGLE_X86_LINUX_SRCS))
# the nanoapps that come with it: none is in our list
COMMON_SRCS := $(filter-out apps/%, $(COMMON_SRCS))
