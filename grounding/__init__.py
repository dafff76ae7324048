"""From words and fixations to grounded plans; knows no network and no image source."""
