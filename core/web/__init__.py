"""A coefficient image as one HTML file in which anyone can choose the light: `page.write`."""
