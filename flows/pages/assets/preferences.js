// The switches of language and theme: the server lays the pages out by these two cookies.
window.dash_clientside = Object.assign({}, window.dash_clientside, {
    preferences: {
        keep: function (language, theme) {
            const year = 365 * 24 * 3600;
            const attributes = `; path=/; max-age=${year}; samesite=strict`;
            document.cookie = `mimucal_language=${language}${attributes}`;
            document.cookie = `mimucal_theme=${theme}${attributes}`;
            window.location.reload();
            return window.dash_clientside.no_update;
        },
    },
});
