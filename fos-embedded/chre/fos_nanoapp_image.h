/*
 * A model image that arrives in parts, and whether it is sound: nothing of the model that runs is touched before that.
 */
#ifndef FOS_NANOAPP_IMAGE_H
#define FOS_NANOAPP_IMAGE_H

#include <stdbool.h>

#include "fos.h"
#include "fos_nanoapp_messages.h"

/* Forgets what has arrived. */
void fos_image_start(void);

/*
 * Takes the bytes of a FOS_MESSAGE_MODEL. True if that is to be answered with `*status`: the image is whole, and sound for
 * a hub with these scales if FOS_STATUS_OK; or the part cannot be taken. What follows of an image after that has no answer.
 */
bool fos_image_take_part(const uint8_t *bytes, size_t length, const fos_scales *scales, fos_status *status);

/* The image that was found sound, until the next part comes. */
const uint8_t *fos_image_arrived(size_t *length);

#endif
